"""The ladder: rungs read and scored, runs kept and summed up, figures and page of them."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from numpy.testing import assert_array_equal

from baselines.evaluation.backends import JoblibBackend
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.errors import ConfigError, UnknownNameError
from training import transitions
from training.ladder import benchmark, cleanrl_trainer, figures, trainers
from training.ladder.play import POINTS, Watch, play, random_actions
from training.ladder.rungs import (
    RANDOM,
    Score,
    find_algorithms,
    find_named,
    read_algorithms,
    read_rungs,
    write_scores,
)
from training.ladder.runs import Job, Run, add_run, current, find, marl_eval, read_runs, write_runs

TINY = {"scenario": "near", "learn": "motion", "physics": "kinematic", "decision_period": 10,
        "discount": 0.9, "task.n_robots": 3, "task.duration": 20.0}  # fmt: skip

SCORES = {RANDOM: Score(mean=2.0), "nc": Score(mean=4.0), "no-error": Score(mean=12.0)}

every_rung = pytest.mark.parametrize("name", list(read_rungs()))


@pytest.fixture
def rung(tmp_path):
    """A rung of seconds, in a file of its own."""
    file = tmp_path / "tiny.yaml"
    card = {"title": "Tiny", "hard": "Nothing.", "episodes": 2, "robot_steps": 1000, "also": []}
    tree = {**TINY, "card": {**card, "controllers": ["nc"]}}
    file.write_text(yaml.safe_dump(tree, sort_keys=False))
    return read_rungs(tmp_path)["tiny"]


@pytest.fixture
def scored(rung):
    """The same with scores on its card."""
    return replace(rung, card=rung.card.model_copy(update={"scores": SCORES}))


def run_of(rung, algorithm="sb3_ppo", seed=0, scores=(7.0, 7.0), steps=1000):
    """A run that is made up."""
    job = Job(rung, read_algorithms()[algorithm], seed)
    curve = [
        {"robot_steps": 500, "wall_s": 30.0 + seed, "scores": [1.0 + seed, 2.0]},
        {"robot_steps": 1000, "wall_s": 60.0, "scores": list(scores)},
    ]
    results = curve, scores, scores, {"numpy": "2"}
    return Run(rung.name, algorithm, seed, job.key, job.config, steps, 60.0, *results)


def test_the_rungs_stand_in_order_and_every_card_is_filled_in():
    rungs = list(read_rungs().values())
    assert [each.card.rung for each in rungs] == list(range(1, len(rungs) + 1))
    assert [each.name for each in rungs[:3]] == ["near", "es1_clean", "es1"]
    assert all(each.card.title and each.card.hard for each in rungs)


@every_rung
def test_what_is_learned_in_training_can_be_played_in_the_test(name):
    rung = read_rungs()[name]
    trained, tested = (ArrayEnv(**each) for each in (rung.keywords, rung.test_keywords))
    assert trained.observation_space.shape == tested.observation_space.shape
    assert trained.observation_layout.names == tested.observation_layout.names
    assert trained.action_space == tested.action_space
    assert tested.world.scenario == rung.test_scenario
    assert tested.config.physics is None


def test_a_transfer_rung_is_scored_on_more_robots_than_it_is_trained_with():
    for name, robots in (("es2", 50), ("es3", 100)):
        rung = read_rungs()[name]
        assert ArrayEnv(**rung.keywords).world.n_robots == 10
        assert rung.test_scenario.task.n_robots == robots


def test_a_score_is_normalised_between_random_actions_and_the_oracle(scored):
    assert [scored.normalised(x) for x in (2.0, 7.0, 12.0, 22.0)] == [0.0, 0.5, 1.0, 2.0]
    for alone in (RANDOM, "no-error"):
        card = scored.card.model_copy(update={"scores": {alone: Score(mean=1.0)}})
        with pytest.raises(ConfigError, match="rung 'tiny': no scores; run swarm-forage benchmark"):
            replace(scored, card=card).normalised(1.0)


def test_scores_are_written_below_what_is_written_by_hand(rung):
    before = rung.file.read_text()
    for scores in ({RANDOM: Score(mean=1.5)}, SCORES):
        write_scores(rung, scores)
        assert rung.file.read_text().startswith(before)
        assert read_rungs(rung.file.parent)["tiny"].card.scores == scores
    assert read_rungs(rung.file.parent)["tiny"].keywords == TINY
    rung.file.write_text(before.replace("discount: 0.9\n", ""))
    write_scores(rung, SCORES)
    with pytest.raises(ConfigError, match=r"tiny\.yaml: has no discount; add .*discount: 0"):
        read_rungs(rung.file.parent)


def test_references_are_scored_in_the_test_worlds(rung, tmp_path):
    scores = benchmark.score_references(rung, tmp_path / "episodes", JoblibBackend())
    assert list(scores) == [RANDOM, "nc", "no-error"]
    assert {each.episodes for each in scores.values()} == {2}
    assert read_rungs(tmp_path)["tiny"].card.scores.keys() == scores.keys()


def test_one_seed_one_score_and_blocks_do_not_matter(rung, monkeypatch):
    keywords = rung.test_keywords | {"task.area_distance": 0.62, "task.duration": 60.0}
    act = random_actions(keywords)
    still = ArrayEnv(**keywords).action_space.low * 0.0

    def straight(observations, begins, stochastic):
        return np.broadcast_to(still, (*observations.shape[:2], *still.shape))

    together = play(keywords, straight, [1, 2, 3])
    monkeypatch.setattr("training.ladder.play.ROWS", 3)
    assert play(keywords, straight, [1, 2, 3]) == together
    assert len(play(keywords, act, [5])) == 1


@pytest.mark.parametrize(
    ("name", "easier"), [("es1_clean", {}), ("waypoints", {"task.tolerance": 4.0})]
)
def test_a_score_is_what_an_evaluation_counts(name, easier):
    keywords = {**read_rungs()[name].test_keywords, **easier}
    env = ArrayEnv(**keywords)
    kind = env.task.episode
    observations, _ = env.reset([3])
    meter, act, period = kind.meter(env.loop), random_actions(keywords), env.config.decision_period
    tick = 0
    while not env.is_over.any():
        observations, *_ = env.step(act(observations, env.is_over, False))
        tick += period
        meter.sample(tick)
    (found,) = meter.results()
    assert found[kind.score] > 0.0
    assert play(keywords, random_actions(keywords), [3]) == [found[kind.score]]


def test_unknown_names_are_told():
    with pytest.raises(UnknownNameError, match="no algorithm named 'mapo'"):
        find_algorithms(["mapo"])
    named = find_named("rung", ["es1", "near"], read_rungs())
    assert [each.name for each in named] == ["near", "es1"]


def test_a_run_is_found_again_unless_its_configuration_has_changed(scored):
    job, runs = Job(scored, read_algorithms()["sb3_ppo"], 0), [run_of(scored)]
    assert find(job, []) is None
    assert find(job, runs) is runs[0]
    assert find(replace(job, budget=999), runs) is None
    other = replace(scored, keywords={**scored.keywords, "discount": 0.5})
    assert find(replace(job, rung=other), runs) is None
    assert current(runs, [other], find_algorithms(None)) == []


def test_runs_are_read_as_written_and_replaced_by_those_that_are_as_long(scored, tmp_path):
    file, algorithms = tmp_path / "runs.parquet", find_algorithms(None)
    assert read_runs(file) == []
    made = [run_of(scored, seed=k) for k in range(3)]
    runs = [replace(each, scores=[7.0], scores_by_chance=[each.seed]) for each in made]
    write_runs(runs, file)
    assert read_runs(file) == runs
    odd, short = replace(runs[1], key="old"), replace(runs[1], robot_steps=9)
    write_runs([runs[0], odd, runs[2]], file)
    add_run(short, file)
    assert read_runs(file) == [runs[0], odd, runs[2], short], "the longer one is kept"
    assert current(read_runs(file), [scored], algorithms) == [runs[0], short, runs[2]]
    add_run(runs[1], file)
    assert read_runs(file) == [runs[0], runs[2], runs[1]]
    assert current([runs[1], short], [scored], algorithms) == [runs[1]]


def test_a_file_that_holds_no_runs_is_refused(scored, tmp_path):
    file = tmp_path / "runs.parquet"
    write_runs([run_of(scored)], file)
    for content in (file.read_bytes()[:-100], b"", b"[]"):
        file.write_bytes(content)
        with pytest.raises(ConfigError, match=r"runs.parquet: holds no runs of the ladder; move"):
            read_runs(file)


def test_a_library_that_is_missing_is_told_and_left_out(monkeypatch):
    lines = []
    monkeypatch.setattr(benchmark, "say", lines.append)
    monkeypatch.setitem(benchmark.TRAINERS, "benchmarl", "benchmarl_is_not_here")
    found = benchmark.installed(find_algorithms(["sb3_ppo", "mappo"]))
    assert [each.name for each in found] == ["sb3_ppo"]
    assert [line.partition(":")[0] for line in lines] == ["mappo is left out"]


def test_cleanrl_s_ppo_learns_with_a_rate_that_falls(rung, monkeypatch):
    rates, own = [], read_algorithms()["cleanrl_ppo"]
    monkeypatch.setattr(
        cleanrl_trainer, "update",
        lambda agent, optimiser, seen, options: rates.append(optimiser.param_groups[0]["lr"]),
    )  # fmt: skip
    small = own.model_copy(update={"settings": {**own.settings, "steps": 8}})
    watch = Watch(rung.test_keywords, 480, 2)
    cleanrl_trainer.train(rung, small, 0, watch)
    assert rates == pytest.approx([3e-4, 1.5e-4])
    assert [point["robot_steps"] for point in watch.curve] == [240, 480]
    assert len(play(rung.test_keywords, watch.best, [1000], stochastic=True)) == 1


def test_a_memory_is_kept_from_decision_to_decision_of_one_episode(rung):
    own = read_algorithms()["ppo_gru"]
    small = own.model_copy(update={"worlds": 2, "settings": {"n_steps": 4, "n_minibatches": 1}})
    watch = Watch({**rung.test_keywords, "learn": "everything"}, 960, 1)
    tiny = replace(rung, keywords={**rung.keywords, "learn": "everything"})
    trainers.by_own_ppo(tiny, small, 0, watch)
    assert len(watch.curve) == POINTS
    seen = np.random.default_rng(0).random(
        (2, 3, len(ArrayEnv(**watch.keywords).observation_layout))
    )
    first, later, mixed = (
        watch.best(seen.astype(np.float32), np.array(begins), False)
        for begins in ([True, True], [False, False], [True, False])
    )
    assert (first != later).any(axis=(1, 2)).all()
    assert_array_equal(mixed[0], first[0])
    assert (mixed[1] != later[1]).any()


def test_offline_algorithms_learn_and_are_scored_in_the_action_space_of_the_transitions(
    rung, monkeypatch
):
    recorded, played = [], []

    def read(folder):
        recorded.append(transitions.read(folder))
        return recorded[0]

    def play(keywords, *given, **chosen):
        played.append(keywords)
        return [1.0]

    monkeypatch.setattr(trainers, "read", read)
    monkeypatch.setattr(benchmark, "play", play)
    rwr = read_algorithms()["rwr"]
    dataset = {"policies": ["random", "ssgikf"], "episodes": 2, "learners": 1}
    small = rwr.model_copy(update={"settings": {**rwr.settings, "dataset": dataset, "batch": 100}})
    run = benchmark.make(Job(rung, small, 3, 300))
    assert [point["robot_steps"] for point in run.curve] == [100, 200, 300]
    assert set(recorded[0]["seed"]) == {10_006, 10_007}
    assert set(recorded[0]["policy"]) == {"random", "ssgikf"}
    assert len(recorded[0]["reward"]) == 2 * 2 * 200
    for keywords in played:
        assert (keywords["action"], keywords["decision_period"]) == ("wheels", 1)
        assert (keywords["reflexes"], keywords["walk"]) == (False, False)
        assert keywords["task.n_robots"] == 3
    assert len(played) == 4


def test_an_algorithm_for_some_rungs_is_run_on_no_others(rung):
    rwr, ppo = (read_algorithms()[name] for name in ("rwr", "sb3_ppo"))
    assert [job.algorithm for job in benchmark.jobs_of([rung], [rwr, ppo], 1, None)] == [ppo]
    assert len(benchmark.jobs_of([read_rungs()["es1"]], [rwr, ppo], 1, None)) == 2
    with pytest.raises(ConfigError, match="rwr is for es1; name such a rung"):
        benchmark.jobs_of([rung], [rwr], 1, None)


@pytest.fixture
def weighting(rung):
    """The rung of the weighting, in a minute's world of fast robots and near areas."""
    busy = {"task.duration": 100.0, "task.area_distance": 0.7, "robot.cruise_speed": 0.12}
    return replace(rung, keywords={**read_rungs()["weighting"].keywords, **busy})


def test_from_exchange_to_exchange_a_score_is_that_of_whole_episodes(weighting):
    keywords = weighting.test_keywords
    in_ticks = {name: value for name, value in keywords.items() if name != "step_on"}

    def half(observations, begins, stochastic):
        return np.zeros((*observations.shape[:2], 2), np.float32)

    scores = play(keywords, half, [1, 2, 3])
    assert scores == play(in_ticks, half, [1, 2, 3])
    assert len(set(scores)) > 1


def test_a_training_from_exchange_to_exchange_counts_ticks(weighting, monkeypatch):
    made = []

    class Noted(trainers.PPO):
        def __init__(self, policy, env, gamma, seed, **settings):
            made.append((env.env.n_worlds, env.np_random[0].bit_generator.state, gamma, seed))
            super().__init__(policy, env, gamma=gamma, seed=seed, **settings)

    monkeypatch.setitem(trainers.MODELS, "", Noted)
    algorithm = read_algorithms()["sb3_ppo"]
    settings = {"n_steps": 8, "batch_size": 80}
    small = algorithm.model_copy(update={"worlds": 2, "settings": settings})
    run = benchmark.make(Job(weighting, small, 5, 16_000))
    of_seed = np.random.default_rng(5).bit_generator.state
    assert made == [(2, of_seed, weighting.keywords["discount"], 5)]
    steps = [point["robot_steps"] for point in run.curve]
    assert steps == sorted(steps)
    assert all(each % 10 == 0 for each in steps)
    a_rollout = 2 * 10 * 8 * 1000  # at most: no step is longer than an episode
    assert steps[-2] < 16_000 <= steps[-1] < 16_000 + a_rollout
    assert steps[0] > 8 * 2 * 10  # a decision is no tick


def test_the_file_of_marl_eval_is_a_tree_by_rung_algorithm_and_seed(scored):
    runs = [run_of(scored), run_of(scored, seed=1), run_of(scored, "mappo")]
    tree = marl_eval(runs)["swarm_forage"]["tiny"]
    assert set(tree) == {"sb3_ppo", "mappo"}
    assert set(tree["sb3_ppo"]) == {"seed_0", "seed_1"}
    first = tree["sb3_ppo"]["seed_1"]
    assert first["step_0"] == {"step_count": 500, "elapsed_time": 31.0, "score": [2.0, 2.0]}
    assert first["absolute_metrics"] == {"score": [7.0]}
    json.dumps(tree)


def test_algorithms_differ_in_colour_and_from_the_lines_of_controllers(scored):
    """Among all algorithms MAPPO and VDN would have one colour."""
    runs = [run_of(scored), *(run_of(scored, name) for name in ("qmix", "mappo", "vdn"))]
    figure = figures.curves(scored, runs, "command")
    learned, known = (
        {line.get_color() for line in figure.axes[0].lines if line.get_label()[:1] in start}
        for start in ("PQMV", "_")
    )
    assert len(learned) == 4
    assert not learned & known


def test_a_policy_acts_for_every_robot_of_every_world_with_the_states_that_it_gave():
    asked = []

    def predict(rows, states, starts, deterministic):
        asked.append((rows.shape, states, starts.tolist(), deterministic))
        return rows[:, :2] * 2.0, len(asked)

    act = trainers._acting(SimpleNamespace(predict=predict))
    seen = np.arange(24.0).reshape(2, 3, 4)
    begins = [True, True], [False, True], [True, True]
    for each, stochastic in zip(begins, (False, True, False), strict=True):
        given = act(seen, np.array(each), stochastic)
        assert given.tolist() == (2.0 * seen[..., :2]).tolist()
    assert asked == [
        ((6, 4), None, [True] * 6, True),
        ((6, 4), 1, [False] * 3 + [True] * 3, False),
        ((6, 4), None, [True] * 6, True),
    ]


def test_a_policy_is_told_where_an_episode_starts(rung):
    told, random = [], random_actions(rung.test_keywords)

    def act(observations, begins, stochastic):
        told.append(begins.tolist())
        return random(observations, begins, stochastic)

    play(rung.test_keywords, act, [1, 2])
    assert told == [[True, True], *[[False, False]] * 19]


def test_a_run_is_scored_in_the_test_worlds_by_its_best_policy(monkeypatch, rung):
    played = []

    def train(rung, algorithm, seed, watch):
        watch.best = ("best", seed)
        watch.curve += [{"wall_s": 3.0}, {"wall_s": 5.0}, {"wall_s": 9.0}]
        played.append((watch.keywords, watch.robot_steps, watch.episodes))

    monkeypatch.setattr(benchmark, "trainer_of", lambda algorithm: train)

    def play(keywords, *given, stochastic=False):
        played.append((keywords, *given, stochastic))
        return [len(given[1]) - 0.5 * stochastic + 10 * ("physics" in keywords)]

    monkeypatch.setattr(benchmark, "play", play)
    job = Job(rung, read_algorithms()["sb3_ppo"], 4, 600)
    found = benchmark.make(job)
    told = {name: value for name, value in TINY.items() if name != "physics"}
    tested = [
        (keywords, ("best", 4), range(1000, 1002), stochastic)
        for keywords in (told, {**told, "physics": "kinematic"})
        for stochastic in (False, True)
    ]
    assert played == [(told, 600, 4), *tested]
    assert (found.scores_kinematic, found.scores_kinematic_by_chance) == ([12.0], [11.5])
    assert (found.train_s, found.seed, found.robot_steps) == (9.0, 4, 600)
    assert (found.scores, found.scores_by_chance) == ([2.0], [1.5])
    assert (found.rung, found.algorithm, found.key) == ("tiny", "sb3_ppo", job.key)


def test_runs_that_are_made_are_kept_and_told_one_by_one(monkeypatch, scored, tmp_path):
    lines, seconds, asked = [], iter((100.0, 103.0, 106.0, 107.0)), []
    monkeypatch.setattr(benchmark, "say", lines.append)
    monkeypatch.setattr(benchmark, "time", SimpleNamespace(monotonic=lambda: next(seconds)))
    monkeypatch.setattr(benchmark, "trainer_of", lambda algorithm: asked.append(algorithm.name))
    jobs = benchmark.jobs_of([scored], [read_algorithms()["sb3_ppo"]], 3, 2_500_000)
    made = [replace(run_of(scored, seed=job.seed, steps=2_500_000), key=job.key) for job in jobs]
    file = tmp_path / "runs.parquet"
    write_runs(made[:1], file)
    backend = SimpleNamespace(run=lambda make, todo: (made[job.seed] for job in todo))
    benchmark.run_jobs(jobs, file, backend)
    assert lines == [
        f"1 of 3 runs found in {file}, 2 to make",
        "tiny, sb3_ppo, seed 1: 7.0 after 2.5 M robot-steps in 60 s; about 3 s left",
        "tiny, sb3_ppo, seed 2: 7.0 after 2.5 M robot-steps in 60 s; about 0 s left",
        "done in 7 s",
    ]
    assert asked == ["sb3_ppo"], "what is missing is told before anything trains"
    assert read_runs(file)[2].robot_steps == 2_500_000


def test_references_are_scored_by_their_own_episodes(monkeypatch, rung, tmp_path):
    two_of_each = [[0.0, 2.0], [4.0, 4.0]]
    monkeypatch.setattr(benchmark.Plan, "by_configuration", lambda plan: two_of_each)
    monkeypatch.setattr(benchmark, "scores", list)
    monkeypatch.setattr(benchmark, "run_with_progress", lambda *given: None)
    monkeypatch.setattr(benchmark, "play", lambda *given: [5.0, 6.0])
    monkeypatch.setattr(benchmark, "write_scores", lambda rung, scores: None)
    found = benchmark.score_references(rung, tmp_path, None)
    assert {name: (score.mean, score.episodes) for name, score in found.items()} == {
        RANDOM: (5.5, 2), "nc": (1.0, 2), "no-error": (4.0, 2),
    }  # fmt: skip
    assert found["nc"].low < 1.0 < found["nc"].high
    assert (found["no-error"].low, found["no-error"].high) == (None, None)


def test_random_actions_are_those_of_a_seed(rung):
    space = ArrayEnv(**rung.test_keywords).action_space
    seen = np.zeros((2, 3, 5))
    for options, seed in (({}, 0), ({"seed": 4}, 4)):
        expected = np.random.default_rng(seed).uniform(space.low, space.high, (2, 3, 2))
        found = random_actions(rung.test_keywords, **options)(
            seen, np.ones(len(seen), np.bool_), True
        )
        np.testing.assert_array_equal(found, expected.astype(np.float32))
    chosen = random_actions({**rung.test_keywords, "discrete": (2, 2)})(seen, None, True)
    assert set(chosen.ravel()) <= set(range(4))


def test_algorithms_are_files_of_a_folder_by_name(tmp_path):
    for name, title in (("b", "Second"), ("a", "First")):
        (tmp_path / f"{name}.yaml").write_text(f"title: {title}\nworlds: 3\n")
    found = read_algorithms(tmp_path)
    assert [(name, each.name) for name, each in found.items()] == [("a", "a"), ("b", "b")]
    (tmp_path / "c.yaml").write_text("heading: Third\n")
    read_algorithms.cache_clear()
    with pytest.raises(ConfigError, match=r"c\.yaml.*heading"):
        read_algorithms(tmp_path)
