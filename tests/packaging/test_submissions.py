"""Files for others: the paper, the container, the development container, the cards of policies."""

import json
import re
import tomllib
from pathlib import Path

import cards
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
PAPER = ROOT / "docs" / "submissions" / "paper.md"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_paper_cites_what_its_bibliography_has_and_is_as_long_as_a_journal_takes():
    text = PAPER.read_text(encoding="utf-8")
    entries = re.findall(r"^@\w+\{(\w+),", PAPER.with_suffix(".bib").read_text(), re.MULTILINE)
    assert set(re.findall(r"@(\w+)[;\]]", text)) == set(entries)
    body = text.split("---", 2)[2]
    assert 250 <= len(body.split()) <= 1000
    for image in re.findall(r"\]\((\S+\.png)\)", body):
        assert (PAPER.parent / image).is_file()


def test_the_paper_gives_the_numbers_of_the_readme():
    readme, paper = (ROOT / "README.md").read_text(), PAPER.read_text(encoding="utf-8")
    for figure in ("32 of", "5 of 8", "164 of 182", "237", "174"):
        assert figure in readme, figure
        assert figure in paper, figure


def test_the_container_gets_what_it_copies_and_installs_extras_that_there_are():
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    seen = set((ROOT / ".dockerignore").read_text(encoding="utf-8").split())
    for line in re.findall(r"^COPY (.*) \S+$", text, re.MULTILINE):
        for name in line.split():
            assert (ROOT / name).exists(), name
            assert f"!{name}" in seen, name
    (extras,) = re.findall(r"'\.\[([a-z,]+)\]'", text)
    assert set(extras.split(",")) <= set(PROJECT["optional-dependencies"])
    (python,) = re.findall(r"^FROM python:(\d\.\d+)", text, re.MULTILINE)
    assert f"Programming Language :: Python :: {python}" in PROJECT["classifiers"]


def test_the_development_container_makes_a_target_that_there_is():
    made = json.loads((ROOT / ".devcontainer" / "devcontainer.json").read_text(encoding="utf-8"))
    make, target = made["postCreateCommand"].split()
    assert make == "make"
    assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(), re.MULTILINE)


@pytest.mark.parametrize("name", cards.POLICIES)
def test_a_card_of_a_policy_has_the_head_that_the_hub_reads_and_its_scores(name):
    _, head, body = cards.model_card(name).split("---\n", 2)
    known = yaml.safe_load(head)
    (index,) = known["model-index"]
    assert known["license"] == "mit"
    assert index["name"] == name
    values = [result["metrics"][0]["value"] for result in index["results"]]
    assert values
    assert all(value > 100 for value in values)
    assert re.search(r"^swarm-forage train (motion|weighting) ", body, re.MULTILINE)
