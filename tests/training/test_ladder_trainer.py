"""How the ladder's runs are made by stable-baselines3, kept and told; nothing trains."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.errors import ConfigError
from training.ladder import benchmark, cards, sb3_trainer
from training.ladder.play import play, random_actions
from training.ladder.rungs import RANDOM, Algorithm, Card, Rung, Score, _number, read_algorithms
from training.ladder.runs import Job, Run, keep, over_all, read_run, rows_of

TINY = {"scenario": "es1", "learn": "motion", "physics": "kinematic", "task.n_robots": 3,
        "task.duration": 2.0, "discount": 0.75}  # fmt: skip


@pytest.fixture
def rung(tmp_path):
    scores = {RANDOM: Score(mean=2.0), "no-error": Score(mean=12.0)}
    card = Card(controllers=("nc",), also=(), episodes=2, curve_episodes=1, scores=scores)
    return Rung("tiny", tmp_path / "tiny.yaml", TINY, card)


def run_of(algorithm="sb3_ppo", seed=0, score=7.0, rung="tiny", steps=480):
    curve = [{"robot_steps": 240, "wall_s": 30.0, "scores": [1.0]},
             {"robot_steps": steps, "wall_s": 65.4, "scores": [score]}]  # fmt: skip
    results = curve, (score,), (0.5 * score,), {"numpy": "2"}
    return Run(rung, algorithm, seed, "key", {}, steps, 65.4, *results)


def test_a_policy_acts_for_every_robot_of_every_world_with_the_states_that_it_gave():
    asked = []

    def predict(rows, states, starts, deterministic):
        asked.append((rows.shape, states, starts.tolist(), deterministic))
        return rows[:, :2] * 2.0, len(asked)

    act = sb3_trainer._acting(SimpleNamespace(predict=predict))
    seen = np.arange(24.0).reshape(2, 3, 4)
    begins = [True, True], [False, True], [True, True]
    for each, by_chance in zip(begins, (False, True, False), strict=True):
        given = act(seen, np.array(each), by_chance)
        assert given.tolist() == (2.0 * seen[..., :2]).tolist()
    assert asked == [
        ((6, 4), None, [True] * 6, True),
        ((6, 4), 1, [False] * 3 + [True] * 3, False),
        ((6, 4), None, [True] * 6, True),
    ]


def test_a_policy_is_told_where_an_episode_starts(rung):
    told, random = [], random_actions(rung.test_keywords)

    def act(observations, begins, by_chance):
        told.append(begins.tolist())
        return random(observations, begins, by_chance)

    play(rung.test_keywords, act, [1, 2])
    assert told == [[True, True], [False, False]]


@pytest.mark.parametrize(
    ("discrete", "keywords", "given"),
    [(False, {}, {}), (True, {}, {"discrete": True}),
     (True, {"discrete": (3, 5)}, {"discrete": (3, 5)})],
)  # fmt: skip
def test_a_run_is_scored_in_the_test_worlds_by_its_best_policy(
    monkeypatch, rung, discrete, keywords, given
):
    played = []

    def train(rung, algorithm, seed, watch):
        watch.best = ("best", seed)
        watch.curve += [{"wall_s": 3.0}, {"wall_s": 5.0}, {"wall_s": 9.0}]
        played.append((watch.keywords, watch.robot_steps, watch.episodes))

    trainer = SimpleNamespace(is_discrete=lambda algorithm: discrete, train=train)
    monkeypatch.setattr(benchmark, "trainer_of", lambda algorithm: trainer)

    def play(*given, by_chance=False):
        played.append((*given, by_chance))
        return [len(given[2]) - 0.5 * by_chance]

    monkeypatch.setattr(benchmark, "play", play)
    own = replace(rung, keywords={**TINY, **keywords})
    job = Job(own, read_algorithms()["sb3_ppo"], 4, 600)
    found = benchmark.make(job)
    told = {name: value for name, value in TINY.items() if name != "physics"} | given
    tested = [(told, ("best", 4), [1000, 1001], by_chance) for by_chance in (False, True)]
    assert played == [(told, 600, 1), *tested]
    assert (found.train_s, found.seed, found.robot_steps) == (9.0, 4, 600)
    assert (found.scores, found.scores_by_chance) == ([2.0], [1.5])
    assert (found.rung, found.algorithm, found.key) == ("tiny", "sb3_ppo", job.key)


def test_runs_that_are_made_are_kept_and_told_one_by_one(monkeypatch, rung, tmp_path):
    said, seconds, asked = [], iter((100.0, 103.0, 106.0, 107.0)), []
    monkeypatch.setattr(benchmark, "say", said.append)
    monkeypatch.setattr(benchmark, "time", SimpleNamespace(monotonic=lambda: next(seconds)))
    monkeypatch.setattr(benchmark, "trainer_of", lambda algorithm: asked.append(algorithm.name))
    jobs = benchmark.jobs_of([rung], [read_algorithms()["sb3_ppo"]], 3, 2_500_000)
    keep(replace(run_of(steps=2_500_000), key=jobs[0].key), jobs[0].file(tmp_path))

    def ran(make, todo):
        yield from (replace(run_of(seed=job.seed, steps=2_500_000), key=job.key) for job in todo)

    benchmark.run_jobs(jobs, tmp_path, SimpleNamespace(run=ran))
    assert said == [
        f"1 of 3 runs found in {tmp_path}, 2 to make",
        "tiny, sb3_ppo, seed 1: 7.0 after 2.5 M robot-steps in 65 s; about 3 s left",
        "tiny, sb3_ppo, seed 2: 7.0 after 2.5 M robot-steps in 65 s; about 0 s left",
        "done in 7 s",
    ]
    assert asked == ["sb3_ppo"], "what is missing is told before anything trains"
    kept = tmp_path / "tiny" / "sb3_ppo" / "seed2.json"
    assert read_run(kept).robot_steps == 2_500_000
    text = kept.read_text("utf-8")
    assert text == json.dumps(json.loads(text), indent=1) + "\n"


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"rung": 1', '{"odd": 2}'])
def test_a_file_that_is_no_run_is_refused(tmp_path, text):
    assert read_run(tmp_path / "none.json") is None
    (tmp_path / "x.json").write_text(text)
    with pytest.raises(ConfigError, match=r"x.json: is no run of the ladder; move it away"):
        read_run(tmp_path / "x.json")


def test_a_key_does_not_depend_on_the_order_of_keywords_nor_on_title_and_share(rung):
    algorithm = read_algorithms()["sb3_ppo"]
    job = Job(rung, algorithm, 0)
    turned = replace(rung, keywords=dict(reversed(TINY.items())))
    assert replace(job, rung=turned).key == job.key
    named = algorithm.model_copy(update={"title": "Another", "share": 0.5})
    assert replace(job, algorithm=named).key == job.key
    # What an algorithm does not say is not in its key: a new setting leaves kept runs as they are.
    assert Job(rung, Algorithm(name="one"), 0).config["algorithm"] == {"name": "one"}


def test_algorithms_are_told_the_best_first_and_those_of_most_rungs_before(rung):
    found = rows_of(
        rung, [run_of(score=3.0), run_of("mappo", score=9.0), run_of("qmix", score=5.0)]
    )
    assert [row.algorithm for row in found] == ["mappo", "qmix", "sb3_ppo"]
    long = [run_of(steps=480), run_of(seed=1, steps=960), run_of(seed=2, steps=720)]
    assert rows_of(rung, long)[0].robot_steps == 960
    other = replace(rung, name="other")
    both = [run_of(score=3.0), run_of(score=3.0, rung="other"), run_of("mappo", score=9.0),
            run_of("qmix", score=12.0)]  # fmt: skip
    assert list(over_all([rung, other], both)) == ["sb3_ppo", "qmix", "mappo"]


def test_references_are_scored_by_their_own_episodes(monkeypatch, rung, tmp_path):
    two_of_each = [[0.0, 2.0], [4.0, 4.0]]
    monkeypatch.setattr(cards.Plan, "by_configuration", lambda plan: two_of_each)
    monkeypatch.setattr(cards, "scores", list)
    monkeypatch.setattr(cards, "run_with_progress", lambda *given: None)
    monkeypatch.setattr(cards, "play", lambda *given: [5.0, 6.0])
    monkeypatch.setattr(cards, "write_scores", lambda rung, scores: None)
    found = cards.score_references(rung, tmp_path, None)
    assert {name: (score.mean, score.episodes) for name, score in found.items()} == {
        RANDOM: (5.5, 2), "nc": (1.0, 2), "no-error": (4.0, 2),
    }  # fmt: skip
    assert found["nc"].low < 1.0 < found["nc"].high
    assert (found["no-error"].low, found["no-error"].high) == (None, None)


@pytest.mark.parametrize(
    ("value", "text"), [(None, "null"), (0.0, "0"), (1234.56, "1235"), (0.123456, "0.1235")]
)
def test_numbers_of_a_card_have_four_digits(value, text):
    assert _number(value) == text


def test_random_actions_are_those_of_a_seed(rung):
    space = ArrayEnv(**rung.test_keywords).action_space
    seen = np.zeros((2, 3, 5))
    for options, seed in (({}, 0), ({"seed": 4}, 4)):
        expected = np.random.default_rng(seed).uniform(space.low, space.high, (2, 3, 2))
        found = random_actions(rung.test_keywords, **options)(
            seen, np.ones(len(seen), np.bool_), True
        )
        np.testing.assert_array_equal(found, expected.astype(np.float32))


@pytest.mark.parametrize("alone", [RANDOM, "no-error"])
def test_a_score_is_normalised_by_two_others_and_by_one_alone_it_is_not(rung, alone):
    bare = replace(rung, card=rung.card.model_copy(update={"scores": {alone: Score(mean=1.0)}}))
    with pytest.raises(ConfigError, match="rung 'tiny': no scores; run swarm-forage benchmark"):
        bare.normalised(1.0)


def test_algorithms_are_files_of_a_folder_by_name(tmp_path):
    for name, title in (("b", "Second"), ("a", "First")):
        (tmp_path / f"{name}.yaml").write_text(f"title: {title}\nworlds: 3\n")
    (tmp_path / "notes.txt").write_text("no algorithm")
    found = read_algorithms(tmp_path)
    assert {name: (each.name, each.title) for name, each in found.items()} == {
        "a": ("a", "First"), "b": ("b", "Second"),
    }  # fmt: skip
    assert list(found) == ["a", "b"]
    (tmp_path / "c.yaml").write_text("heading: Third\n")
    read_algorithms.cache_clear()
    with pytest.raises(ConfigError, match=r"c\.yaml.*heading"):
        read_algorithms(tmp_path)
