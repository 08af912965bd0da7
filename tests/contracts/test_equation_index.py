"""docs/equations.md: what the docstrings say, no more and no less."""

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

RULE = '''
def weigh():
    """Blend |a| and b: a gain. The rest of it.

    Source: TR, Eq. 10; ANTS, Eq. 3.
    Source: BOIDS, Eqs. 21 and
        22.

    Not in the paper: the order.
    """


class Gain:
    """No source here."""

    def again(self):
        """Blend again.

        Source: TR, Eq. 9.
        """
'''


@pytest.fixture(scope="module")
def page():
    return runpy.run_path(str(ROOT / "docs" / "hooks" / "make_equations.py"))["page"]


def rows(text):
    return [line for line in text.splitlines() if line.startswith("| ") and "baselines" in line]


def test_the_index_is_current(page):
    written = (ROOT / "docs" / "equations.md").read_text(encoding="utf-8")
    assert written == page(ROOT), "docs/equations.md is out of date: run `make docs-equations`"


def test_every_citation_is_a_row_under_its_paper_in_the_order_of_the_equations(page, tmp_path):
    (tmp_path / "baselines").mkdir()
    (tmp_path / "baselines" / "rule.py").write_text(RULE)
    again = "[`baselines.rule.Gain.again`](../baselines/rule.py) | Blend again |"
    weigh = r"[`baselines.rule.weigh`](../baselines/rule.py) | Blend \|a\| and b: a gain |"
    assert rows(page(tmp_path)) == [
        f"| Eq. 9 | {again}",
        f"| Eq. 10 | {weigh}",
        f"| Eq. 3 | {weigh}",
        f"| Eqs. 21 and 22 | {weigh}",
    ]


def test_an_unknown_source_stands_under_other_sources(page, tmp_path):
    (tmp_path / "swarm_forage_env").mkdir()
    docstring = '"""Numbers.\n\nSource: Salmon2011, Table 2.\n"""'
    (tmp_path / "swarm_forage_env" / "__init__.py").write_text(docstring)
    text = page(tmp_path)
    assert "## Other sources" in text
    assert "| Salmon2011, Table 2 | [`swarm_forage_env`]" in text
