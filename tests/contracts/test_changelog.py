"""The changelog has the form that it promises, and a section for the version of the project."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CHANGELOG = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
RELEASES = re.split(r"^## ", CHANGELOG, flags=re.MULTILINE)[1:]
ENTRIES = [
    entry
    for release in RELEASES
    for section in re.split(r"^### ", release, flags=re.MULTILINE)[1:]
    for entry in re.split(r"^- ", section, flags=re.MULTILINE)[1:]
]


def test_every_entry_says_once_whether_it_changes_results():
    assert len(ENTRIES) > 50
    counts = {
        entry[:80]: len(re.findall(r"changes\s+results:\s+(?:yes|no)", entry)) for entry in ENTRIES
    }
    assert not {entry: n for entry, n in counts.items() if n != 1}


def test_the_version_of_the_project_has_a_section_with_its_date():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    first, second = (release.partition("\n")[0] for release in RELEASES[:2])
    assert first == "[Unreleased]"
    assert re.fullmatch(rf"\[{re.escape(project['version'])}\] - \d{{4}}-\d\d-\d\d", second)


def test_the_kinds_of_change_are_those_of_keep_a_changelog():
    kinds = set(re.findall(r"^### (.*)$", CHANGELOG, flags=re.MULTILINE))
    assert kinds <= {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
