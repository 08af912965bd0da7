"""How the results of claims are written: for a terminal, in Markdown, as JSON, as a page."""

import io
import json
import re
import sys
from types import ModuleType, SimpleNamespace

import pytest
from rich.console import Console

from baselines.papers import report
from baselines.papers.claim_types import ClaimResult
from baselines.papers.paper import Paper

FOUND = [
    ClaimResult("a number", 60.0, 99.96, 59.94, 140.4, True),
    ClaimResult("an order", "> 1", 1.2345, None, None, False, 0.00123),
    ClaimResult("a negative number", 1e-2, -150.6, -200.4, 0.012345, True, 0.5),
    ClaimResult("nothing", 4.0, None, None, None, False),
]


def test_numbers_have_three_digits_and_none_after_the_point_from_a_hundred_on():
    assert report.claims_markdown(FOUND).splitlines() == [
        "| claim | published | ours | 95 % interval | p | reproduced |",
        "| --- | --- | --- | --- | --- | --- |",
        "| a number | 60 | 100 | 59.9 to 140 | - | yes |",
        "| an order | > 1 | 1.23 | - | 0.0012 | no |",
        "| a negative number | 0.01 | -151 | -200 to 0.0123 | 0.5 | yes |",
        "| nothing | 4 | - | - | - | no |",
    ]


def test_the_table_of_a_terminal_is_one_line_a_claim_green_or_red_and_the_score_below():
    console = Console(file=io.StringIO(), width=100, color_system="standard", force_terminal=True)
    console.print(report.claims_table(FOUND[:2]))
    shown = console.file.getvalue()
    assert "\x1b[32myes" in shown
    assert "\x1b[31mno" in shown
    assert re.sub("\x1b.*?m", "", shown).splitlines() == [
        "claim    published ours 95 % interval p      reproduced ",
        "a number 60        100  59.9 to 140   -      yes        ",
        "an order > 1       1.23 -             0.0012 no         ",
        "1 of 2 claims reproduced",
    ]


def test_json_is_an_array_of_a_line_for_each_claim_without_p():
    lines = report.to_json(FOUND).splitlines()
    assert (lines[0], lines[-1], len(lines)) == ("[", "]", 2 + len(FOUND))
    wanted = [{k: v for k, v in vars(each).items() if k != "p"} for each in FOUND]
    assert json.loads("\n".join(lines)) == wanted
    with pytest.raises(ValueError, match="JSON"):
        report.to_json([ClaimResult("", 1.0, float("nan"), None, None, True)])


def figure(name, reading):
    return SimpleNamespace(name=name, caption=f"Caption of {name}.", reading=reading)


def test_a_page_lists_what_is_missed_and_says_nothing_if_all_claims_hold():
    figures = figure("one", "Read it so."), figure("two", "")
    paper = Paper(
        "social-odometry", (), figures, 30, {"The filter": "baselines.weighting.sgiff:SGIFF"}
    )
    text = report.page(paper, FOUND, {}, "a command")
    assert "- an order\n- nothing\n" in text
    assert "2 of 4 claims reproduced" in text
    one = "![Caption of one.](figures/one.png)\n\n*Caption of one. Read it so.*"
    assert f"{one}\n\n![Caption of two.](figures/two.png)\n\n*Caption of two.*" in text
    assert "### The filter\n\n" in text
    assert "Nothing." not in text
    assert "Nothing." in report.page(paper, FOUND[:1], {}, "a command")


def test_what_a_paper_leaves_open_is_the_list_of_a_docstring(monkeypatch):
    module = ModuleType("left_open_there", "Title.\n\nNot in the paper:\n- one:\n- two.\n\nMore.")
    module.Nowhere = type("Nowhere", (), {"__doc__": "Says nothing."})
    module.Sentence = type(
        "Sentence", (), {"__doc__": "Title.\n\nBefore.\nWhat is said. Not in the papers: this.\n"}
    )
    monkeypatch.setitem(sys.modules, "left_open_there", module)
    assert report.left_open("left_open_there") == "Not in the paper:\n\n- one:\n- two."
    assert report.left_open("left_open_there:Sentence") == (
        "Before.\nWhat is said. Not in the papers: this."
    )
    with pytest.raises(ValueError, match="left_open_there:Nowhere does not say"):
        report.left_open("left_open_there:Nowhere")
