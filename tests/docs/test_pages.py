"""The code of the guides and of the first pages runs as it is printed, each page as one script."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = ("installation", "quickstart", "trainers", *(f"guides/{path.stem}" for path in sorted(
    (ROOT / "docs" / "guides").glob("*.md")) if path.stem != "index"))  # fmt: skip


def script_of(page):
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    return "\n\n".join(re.findall(r"```python\n(.*?)```", text, re.DOTALL))


@pytest.mark.parametrize("page", PAGES)
def test_the_code_of_a_page_runs(page, tmp_path):
    file = tmp_path / "page.py"
    file.write_text(script_of(page), encoding="utf-8")
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    run = subprocess.run(
        [sys.executable, "-W", "error", str(file)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
        timeout=500,
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip()


def test_every_guide_that_the_navigation_names_has_code():
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    named = set(re.findall(r"guides/(\w+)\.md", navigation)) - {"index"}
    assert named == {page.removeprefix("guides/") for page in PAGES if "/" in page}
    assert all("import" in script_of(f"guides/{name}") for name in named)
