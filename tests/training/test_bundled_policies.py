"""The bundled policies: each loads, is small, says how it was made, and does its work."""

import numpy as np
import pytest

from baselines.evaluation.episode import run_episodes
from baselines.papers import transfer
from baselines.papers.robustness import sound_trips
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.scenarios import find_scenario
from training.controllers import NAMED, NETWORKS
from training.experiment import TEST_SEEDS
from training.network_policy import BUNDLED_NETWORKS
from training.policy_card import read_policy_card
from training.policy_file import BUNDLED, load_policy

SMALL = 100_000
"""Bytes of a policy and its card together, at most."""

NAMES = sorted(file.stem for file in BUNDLED.glob("*.safetensors"))


@pytest.mark.parametrize("name", [*NAMES, *BUNDLED_NETWORKS])
def test_every_policy_says_how_it_was_made_and_is_small(name):
    if name in BUNDLED_NETWORKS:
        source = BUNDLED_NETWORKS[name]
        card = read_policy_card(source).training
    else:
        policy = load_policy(name)
        source, card = policy.source, policy.card
    assert card.command.startswith("swarm-forage train ")
    assert "/tmp" not in card.command
    assert card.score
    assert card.curve[-1].value >= card.curve[0].value
    files = source, source.with_suffix(".json")
    assert sum(file.stat().st_size for file in files) < SMALL


def test_the_folder_of_bundled_policies_holds_policies_and_their_cards_only():
    files = {file.name for file in BUNDLED.iterdir()}
    assert files == {f"{name}{end}" for name in NAMES for end in (".safetensors", ".json")}


@pytest.mark.parametrize("name", [*(controller.name for controller in NAMED), *NETWORKS])
def test_every_learned_controller_beats_robots_that_do_not_communicate(name):
    scenario, seeds = find_scenario("es1"), TEST_SEEDS[:3]
    learned, alone = (
        [
            each.round_trips
            for each in run_episodes(scenario, find_controller(who), seeds, "kinematic")
        ]
        for who in (name, "nc")
    )
    assert min(learned) > max(alone)


@pytest.mark.parametrize(
    ("name", "changes", "worlds"), [("es1", {}, 2), ("es3", {"task.duration": "2400"}, 1)]
)
def test_both_together_make_more_trips_than_either_alone(name, changes, worlds):
    scenario, seeds = find_scenario(name, changes), TEST_SEEDS[:worlds]
    both, weighting, motion = (
        sum(each.round_trips for each in run_episodes(scenario, find_controller(who), seeds))
        for who in ("learned-both", "learned-weighting", "learned-motion")
    )
    assert both > max(weighting, motion)


@pytest.mark.parametrize(
    ("axis", "name"),
    [("distance of the areas [m]", "0.6"), ("obstacles", "walls"), ("obstacles", "gates")],
)
def test_the_robust_motion_makes_more_trips_where_another_learned_one_makes_fewer(axis, name):
    found = (transfer.experiment(who, transfer.AXES[axis][name]).configuration("kinematic")
             for who in ("learned-robust", "ssgikf"))  # fmt: skip
    robust, base = (
        sum(
            each.round_trips
            for each in run_episodes(own.scenario, own.controller, TEST_SEEDS[:10], own.physics)
        )
        for own in found
    )
    assert robust > base


@pytest.mark.parametrize("conspire", ["no", "place"])
def test_the_weighting_trained_among_liars_keeps_most_of_its_trips_among_them(conspire):
    liars = {"faults.liar.share": 0.2, "faults.liar.conspire": conspire}
    trips = {}
    for who in ("learned-sceptical", "ssgikf-sceptical"):
        for faults in ({}, liars):
            scenario = find_scenario("es1", {"task.duration": 900.0, **faults})
            found = run_episodes(scenario, find_controller(who), TEST_SEEDS[:8], "kinematic")
            trips[who, bool(faults)] = np.mean([sound_trips(each) for each in found])
    assert trips["learned-sceptical", True] > 0.8 * trips["learned-sceptical", False]
    assert trips["learned-sceptical", True] > 1.2 * trips["ssgikf-sceptical", True]
