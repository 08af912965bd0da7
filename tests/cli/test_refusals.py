"""Bad input gets one clear line on stderr, before anything runs."""

from concurrent.futures.process import BrokenProcessPool

import pytest


@pytest.fixture(autouse=True)
def _runs_nothing(monkeypatch):
    def run(*_):
        raise AssertionError("a world was run")

    monkeypatch.setattr("baselines.evaluation.runner.warm_up", run)
    monkeypatch.setattr("baselines.evaluation.runner._run_block", run)
    monkeypatch.setattr("training.candidate_rollouts.run_job", run)


EVALUATE = "evaluate", "es1", "nc"
TRAIN = "train", "weighting", "es1"
ARGOS = "--argos", "--target=x86-64"
ON_GPU = "--device=cuda", "--physics=kinematic"

REFUSED = [
    (("evaluate", "es4", "nc"), "named 'es4', did you mean 'es1', 'es2' or 'es3'?"),
    (("evaluate", "es1", "es2"), "no controller named 'es2': it is a scenario; at most one is run"),
    (("evaluate", "mine.yaml", "nc"), "scenario file mine.yaml: must be TOML, under a name that"),
    (("evaluate", "es1", "boids"), "'boids-goal'?; it is a layer, and three make a controller: e"),
    (("evaluate", "es1", "ssgif"), "named 'ssgif', did you mean 'ssgiff' or 'ssgikf'?"),
    (("evaluate", "es1", "nc", "nc"), "controllers 'nc' and 'nc' are the same"),
    (
        ("evaluate", "es1", "ssgiff", "nc", "ssgiff:beta=0.01"),
        "controllers 'ssgiff' and 'ssgiff:beta=0.01' are the same, with the same parameters",
    ),
    (("evaluate", "es1", "nc", "--seed=x"), "an integer. See: swarm-forage evaluate --help"),
    (("evaluate", "es1"), "Missing argument 'controllers"),
    ((*EVALUATE, "--set", "radio.max_range=-1"), ": --set: radio.max_range='-1'"),
    ((*EVALUATE, "--set", "tick=0.1", "--set", "tick=0.2"), "given twice"),
    ((*EVALUATE, "--physics", "rigd"), "--physics: no physics engine named 'rigd', did you"),
    ((*EVALUATE, "--episodes", "0"), "--episodes=0: must be at least 1"),
    ((*EVALUATE, "--threads", "0"), "--threads=0: must be at least 1"),
    ((*EVALUATE, "--address", "auto"), "--address=auto: needs --backend ray"),
    ((*EVALUATE, "--backend", "dask"), "'--backend': 'dask' is not one of 'joblib', 'ray'"),
    ((*EVALUATE, "--device", "cuda"), "--device=cuda: the engine rigid calls a library that"),
    ((*EVALUATE, *ON_GPU), "--device='cuda': needs numba-cuda; pip install"),
    ((*EVALUATE, *ON_GPU, "--workers=2"), "--workers=2: spreads worlds over CPUs; leave it out"),
    ((*EVALUATE, *ON_GPU, "--threads=2"), "--threads=2: spreads worlds over CPUs; leave it out"),
    ((*EVALUATE, *ON_GPU, "--backend=ray"), "--backend=ray: spreads worlds over CPUs; leave it"),
    ((*EVALUATE, *ON_GPU, "--trajectories"), "--trajectories: are recorded on a CPU only; leave"),
    ((*EVALUATE, "--seed", str(2**64 - 1)), "must be a whole number from 0 to 2^64 - 1"),
    ((*EVALUATE, "--out", "taken"), "--out taken: cannot be written"),
    ((*EVALUATE, "--plot", "trips.jpeg"), "--plot trips.jpeg: the name must end in"),
    ((*EVALUATE, "--plot", "taken/trips.png"), "--plot taken/trips.png: cannot be written"),
    ((*EVALUATE, "--episode", "3"), "--episode"),
    (("evaluat", "es1", "nc"), "Did you mean 'evaluate'? See: swarm-forage --help"),
    (("reproduce", "ants2009"), "no paper named 'ants2009', did you mean 'ants2008'?"),
    (("list", "es11"), "no scenario, controller or layer named 'es11', did you mean 'es1'?"),
    (("export", "gather", "--scenario", "aggregation"), "one in which robots forage, such as es1"),
    (("bench", "--fast"), "--fast"),
    (("bench", "--device", "cuda"), "device='cuda': needs numba-cuda; pip install"),
    (("train", "sensing", "es1"), "'sensing' is not one of"),
    ((*TRAIN, "--out=taken/x"), "--out taken/x: cannot be written"),
    (("train", "motion", "es1", "--backend=ray"), "--backend=ray: needs --algorithm cma"),
    ((*TRAIN, "--backend=ray", "--algorithm=imitation"), "needs --algorithm cma"),
    ((*TRAIN, "--backend=ray", "--device=cuda"), "leave out --device=cuda"),
    (("evaluate", "es1", "learned-weighting:policy=gone.safetensors"), "cannot be read"),
    (("evaluate", "es1", "learned-weighting:policy=taken"), "no policy named 'taken'"),
    ((*EVALUATE, "learned-both", "--set=radio.slots=2"), "does not fit 'es1': obs"),
    (("export", "nc", "--out=taken"), "--out taken: cannot be written (File exists); name"),
    (("export", "nc", *ARGOS, "--set=faults.deaf.share=1"), "has faulty robots, which an ARGoS"),
    (("export", "nc", *ARGOS, "--scenario=moving-prey"), "has an area that moves, which an"),
    (("export", "nc", *ARGOS, "--set=tick=0.15"), "has a tick that no second is a multiple of"),
    (("plot", "learning", ".", "--out=a.png"), "policy card .: Is a directory; name a .json"),
    (("bench", "--threads=0"), "Invalid value for '--threads'"),
    (("list", "es1:tick=0.2"), "scenario 'es1:tick=0.2': its parameters are given apart: --set"),
    (("new", "reward", "My-Rule"), "name 'My-Rule': must be small letters"),
    (("new", "reward", "class"), "name 'class': is a word of Python"),
    (("new", "reward", "numpy"), "name 'numpy': Python has a module"),
    (("new", "weighting", "sgikf"), "name 'sgikf': a weighting rule has that name; choose another"),
    (("new", "task", "foraging"), "name 'foraging': a task has that name; choose another"),
    (("benchmark", "ladder", "--rung=nea"), "no rung named 'nea'"),
    (("benchmark", "ladder", "--seeds=0", "--page=ladder.txt"), "must end in .md"),
]


SHOWN = [
    ("nc --video=x.avi", "--video x.avi: the name must end in .mp4, .gif"),
    ("nc --frame=taken/x.png", "--frame taken/x.png: cannot be written"),
    ("nc --html=x.htm", "--html x.htm: the name must end in .html"),
    ("nc --select=10", "--select=10: must be 0 to 9, a robot of es1"),
    ("nc --speed=0", "speed=0: must be 0.1 to 256 times real time"),
    ("nc --size=100", "size=100: must be 400 to 3840"),
    ("nc --start=12", "--start=12: must be 0 to less than the 12 s"),
    ("nc --start=4 --seconds=9", "--seconds=9: must be above 0 and at most 8 [s]"),
    ("nc ssgikf", "nc and ssgikf: only a replay shows two side by side; add --html FILE"),
    ("nc ssgikf --html=a.html --frame=a.png", "without --video and --frame"),
    ("nc ssgikf ssgiff --html=a.html", "3 controllers: at most 2 are shown"),
    ("nc nc --html=a.html", "controllers 'nc' and 'nc' are the same"),
    ("nc --drive=10", "--drive=10: must be 0 to 9, a robot of es1"),
    ("nc --drive=1 --frame=a.png", "leave out --start, --video, --html and --frame"),
    ("nc --drive=1 --start=3", "leave out --start"),
]
"""What `watch es1` refuses of twelve seconds."""

REFUSED += [(("watch", "es1", "--set=task.duration=12", *words.split()), told)
            for words, told in SHOWN]  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "message"), REFUSED, ids=[" ".join(each[0]) for each in REFUSED]
)
def test_bad_input_gets_one_line_and_a_status(command, tmp_path, arguments, message):
    (tmp_path / "taken").write_text("")
    (tmp_path / "mine.yaml").write_text("")
    status, stdout, stderr = command(*arguments)
    assert status == 2
    assert stdout == ""
    assert message in stderr
    assert len(stderr.splitlines()) == 1
    assert stderr.startswith("swarm-forage: ")
    assert "Errno" not in stderr
    assert {each.name for each in tmp_path.iterdir()} == {"taken", "mine.yaml"}


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (BrokenProcessPool("a process"), "a worker process was killed; the"),
        (OSError(28, "No space left on device", "x"), ": No space left on device: 'x'"),
    ],
)
def test_what_goes_wrong_on_the_way_gets_one_line(command, monkeypatch, fault, message):
    def fail(*_):
        raise fault

    monkeypatch.setattr("baselines.evaluation.runner.warm_up", fail)
    status, stdout, stderr = command(*EVALUATE)
    assert (status, stdout) == (1, "")
    assert message in stderr.splitlines()[-1]
    assert len(stderr.splitlines()) == 2, "the run had begun with a line of its own"


HERE = ": must be a file or folder on this machine; write it here, then copy it to the address"

FILES = [
    (*EVALUATE, "--plot"),
    ("plot", "boxplot", "data", "--out"),
    ("watch", "es1", "nc", "--frame"),
    ("watch", "es1", "nc", "--video"),
    ("watch", "es1", "nc", "--html"),
    ("reproduce", "adaptive-boids", "--out"),
    ("reproduce", "adaptive-boids", "--page"),
    ("train", "weighting", "es1", "--out"),
    ("benchmark", "cards", "--out"),
    ("benchmark", "ladder", "--out"),
    ("benchmark", "ladder", "--page"),
]
"""Commands, each with an option that names a file or folder to write."""


READ = [
    (("plot", "boxplot", "{}", "--out=x.png"), "must be a folder on this machine; copy"),
    (("plot", "paths", "{}", "--out=x.png"), "must be the folder of a dataset, or a scenario"),
    ((*EVALUATE, "--trajectories", "--out={}"), "need a folder on this machine as --out"),
]
"""Commands that read a folder, or add to it."""


@pytest.mark.parametrize("address", ["s3://bucket/x", "memory://x"])
@pytest.mark.parametrize(
    ("arguments", "message"),
    [*(((*words, "{}"), f"'{words[-1]}': {{}}{HERE}") for words in FILES), *READ],
)
def test_an_address_is_refused_where_there_must_be_a_file_or_folder(
    command, tmp_path, arguments, message, address
):
    status, stdout, stderr = command(*(each.replace("{}", address) for each in arguments))
    assert (status, stdout, len(stderr.splitlines())) == (2, "", 1)
    assert message.replace("{}", address) in stderr
    assert address in stderr
    assert list(tmp_path.iterdir()) == []
