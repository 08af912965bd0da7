"""The code of the guides and of the first pages runs as it is printed, each page as one script."""

import re

import pytest

from tests.scripts import ROOT, run_python

PAGES = ("installation", "quickstart", "trainers", *(f"guides/{path.stem}" for path in sorted(
    (ROOT / "docs" / "guides").glob("*.md")) if path.stem != "index"))  # fmt: skip


def script_of(page):
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    return "\n\n".join(re.findall(r"```python\n(.*?)```", text, re.DOTALL))


@pytest.mark.parametrize("page", PAGES)
def test_the_code_of_a_page_runs(page, tmp_path):
    file = tmp_path / "page.py"
    file.write_text(script_of(page), encoding="utf-8")
    printed = run_python("-W", "error", file).splitlines()
    assert printed
    claimed = re.findall(r"^print\(.*\)  # (\W?\d.*)$", script_of(page), re.MULTILINE)
    assert not set(claimed) - set(printed), "a comment tells another value than the code prints"


def test_every_guide_that_the_navigation_names_has_code():
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    named = set(re.findall(r"guides/(\w+)\.md", navigation)) - {"index"}
    assert named == {page.removeprefix("guides/") for page in PAGES if "/" in page}
    assert all("import" in script_of(f"guides/{name}") for name in named)
