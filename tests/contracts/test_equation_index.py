"""docs/equations.md: what the docstrings say, no more and no less."""

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def page():
    return runpy.run_path(str(ROOT / "docs" / "hooks" / "make_equations.py"))["page"]


def test_the_index_is_current(page):
    written = (ROOT / "docs" / "equations.md").read_text(encoding="utf-8")
    assert written == page(ROOT), "docs/equations.md is out of date: run `make docs-equations`"
