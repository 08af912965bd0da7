"""A policy without noise that searches by it is reported; one that does not is not."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from baselines.evaluation.tables import noise_lines


@pytest.fixture
def lines(episode):
    """The lines of policies: chance or None for a hand-written controller, and round trips."""

    def lines_of(*rows):
        parameters = [
            {"beta": 1.0} if chance is None else {"policy.chance": chance} for chance, _ in rows
        ]
        configurations = [
            SimpleNamespace(label=f"policy{k}", controller=SimpleNamespace(parameters=each))
            for k, each in enumerate(parameters)
        ]
        episodes = [[replace(episode, round_trips=n) for n in trips] for _, trips in rows]
        return list(noise_lines(configurations, episodes))

    return lines_of


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        ([(False, [240, 0, 250])], ["differ by 142 round trips"]),
        ([(False, [240, 200, 235])], []),
        ([(False, [1000, 1100])], []),
        (
            [(False, [70, 80]), (True, [160, 170])],
            ["it makes 75 round trips without, and 165 with"],
        ),
        ([(False, [150, 150]), (True, [160, 170])], []),
        ([(True, [240, 0]), (None, [240, 0])], []),
        ([(False, [5])], []),
    ],
)
def test_it_is_told_by_episodes_that_differ_and_by_a_score_far_below_that_with_noise(
    lines, rows, says
):
    told = lines(*rows)
    assert len(told) == len(says)
    for line, part in zip(told, says, strict=True):
        assert line.startswith("policy policy0 searches by its noise: ")
        assert part in line
        assert line.endswith("; compare it with policy0,chance=true")


def test_episodes_without_round_trips_have_none():
    controller = SimpleNamespace(parameters={"policy.chance": False})
    configuration = SimpleNamespace(label="x", controller=controller)
    assert not list(noise_lines([configuration], [[SimpleNamespace(goals=3)]]))
