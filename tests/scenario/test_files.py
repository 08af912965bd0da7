"""Scenarios of the user's own, from TOML files."""

import pytest

from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.scenarios import find_scenario

BASE = 'base = "es1"\n'


@pytest.fixture
def file(tmp_path):
    def write(text, name="mine.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_a_file_starts_from_its_base_and_changes_what_it_says(file):
    found = find_scenario(file('base = "es2"\n[radio]\nmax_range = 0.2\n[task]\nn_robots = 40\n'))
    expected = find_scenario("es2", {"max_range": 0.2, "n_robots": 40, "name": "mine"})
    assert found == expected


@pytest.mark.parametrize("text", ["", "tick = 0.05\n", "[task]\nn_robots = 12\n"])
def test_a_file_without_base_is_refused_with_the_line_that_it_lacks(file, text):
    with pytest.raises(
        ConfigError, match=r'mine\.toml: has no base; write base = "es1" at its top'
    ):
        find_scenario(file(text))


def test_a_file_with_a_base_alone_is_that_scenario_under_its_name(file):
    assert find_scenario(file('base = "es1"\n', "plain.toml")) == Scenario(name="plain")


def test_a_file_may_name_its_scenario(file):
    assert find_scenario(file('base = "es1"\nname = "other"\n')).name == "other"


def test_a_file_given_as_text_is_found_and_overridden(file):
    path = str(file('base = "es1"\n[arena]\nlength = 2.0\n'))
    assert find_scenario(path, {"tick": 0.2}) == Scenario(
        name="mine", tick=0.2, arena={"length": 2.0}
    )


@pytest.mark.parametrize(
    ("text", "kind", "parts"),
    [
        ("[radio\n", ConfigError, ["mine.toml", "line 1"]),
        (
            BASE + "[radio]\nmaxrange = 1.0\n",
            UnknownNameError,
            ["radio.maxrange", "'radio.max_range'"],
        ),
        (BASE + "[radios]\nslots = 1\n", UnknownNameError, ["radios.slots", "'radio.slots'"]),
        (
            BASE + "[radio]\nmax_range = -1.0\n",
            ConfigError,
            ["radio.max_range=-1.0", "greater than 0"],
        ),
        (BASE + "tick = nan\n", ConfigError, ["tick=nan", "finite"]),
        (BASE + '[task]\nn_robots = "ten"\n', ConfigError, ["task.n_robots='ten'", "integer"]),
        (BASE + "radio = 3\n", UnknownNameError, ["'radio'"]),
        ('base = "es9"\n', UnknownNameError, ["no scenario named 'es9'", "did you mean"]),
        ("base = 5\n", ConfigError, ["5", "must be a name"]),
        (
            BASE + "[task]\narea_distance = 9.0\n",
            ConfigError,
            ["task.area_distance=9.0", "at most 1.5"],
        ),
    ],
)
def test_a_wrong_file_is_refused_in_one_line_that_says_what_and_why(file, text, kind, parts):
    with pytest.raises(kind) as error:
        find_scenario(file(text))
    message = str(error.value)
    assert [part for part in parts if part not in message] == []
    assert "\n" not in message


def test_a_missing_file_is_refused_by_name(tmp_path):
    with pytest.raises(ConfigError, match=r"file .*none\.toml: No such file or directory$"):
        find_scenario(tmp_path / "none.toml")


def test_a_file_that_is_no_text_is_refused_by_name(tmp_path):
    path = tmp_path / "binary.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match=r"binary\.toml"):
        find_scenario(path)


def test_a_file_that_is_its_own_base_is_refused(file, tmp_path):
    path = tmp_path / "mine.toml"
    file(f'base = "{path.as_posix()}"\n')
    with pytest.raises((ConfigError, UnknownNameError)):
        find_scenario(path)


def test_tables_that_lie_too_deep_are_refused(file):
    deep = "[" + ".".join(["a"] * 3000) + "]\n"
    with pytest.raises(ConfigError, match=r"tables lie too deep in each other.*\[radio\]"):
        find_scenario(file(deep))
    with pytest.raises(ConfigError, match="scenario file"):
        find_scenario(file("x = " + "[" * 3000 + "]" * 3000 + "\n"))
