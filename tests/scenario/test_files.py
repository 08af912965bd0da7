"""Scenarios of the user's own, from TOML files."""

import pytest

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenarios import find_scenario

BASE = 'base = "es1"\n'


@pytest.fixture
def file(tmp_path):
    def write(text):
        path = tmp_path / "mine.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize(
    ("text", "scenario", "numbers"),
    [
        ("", "es1", {"name": "mine"}),
        ('name = "other"\n', "es1", {"name": "other"}),
        ("[radio]\nmax_range = 0.2\n[task]\nn_robots = 40\n", "es2",
         {"name": "mine", "max_range": 0.2, "n_robots": 40}),
    ],
)  # fmt: skip
def test_a_file_starts_from_its_base_and_changes_what_it_says(file, text, scenario, numbers):
    found = file(f'base = "{scenario}"\n{text}')
    assert find_scenario(found) == find_scenario(scenario, numbers)
    assert find_scenario(str(found), {"tick": 0.2}) == find_scenario(
        scenario, numbers | {"tick": 0.2}
    )


@pytest.mark.parametrize("text", ["", "tick = 0.05\n", "[task]\nn_robots = 12\n"])
def test_a_file_without_base_is_refused_with_the_line_that_it_lacks(file, text):
    with pytest.raises(
        ConfigError, match=r'mine\.toml: has no base; write base = "es1" at its top'
    ):
        find_scenario(file(text))


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("[radio\n", ["line 1"]),
        (BASE + "[radio]\nmaxrange = 1.0\n", ["radio.maxrange", "max_range'"]),
        (BASE + "[radio]\nmax_range = -1.0\n", ["radio.max_range=-1.0", "than 0"]),
        (BASE + '[task]\nn_robots = "ten"\n', ["task.n_robots='ten'", "integer"]),
        (BASE + "radio = 3\n", [": no scenario parameter named 'radio'"]),
        ('base = "es9"\n', [": no scenario named 'es9'", "did you mean"]),
        ("base = 5\n", ["5", "must be the name"]),
        ('base = "other.toml"\n', [": base='other.toml'", "such as es1, not a file"]),
    ],
)
def test_a_wrong_file_is_refused_in_one_line_that_says_what_and_why(file, text, parts):
    with pytest.raises(ConfigError) as error:
        find_scenario(file(text))
    message = str(error.value)
    assert message.count("mine.toml: ") == 1
    assert [part for part in parts if part not in message] == []
    assert "\n" not in message


def test_a_file_that_is_missing_or_no_text_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"file .*none\.toml: No such file or directory$"):
        find_scenario(tmp_path / "none.toml")
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match=r"binary\.toml"):
        find_scenario(binary)


def test_tables_that_lie_too_deep_are_refused(file):
    deep = "[" + ".".join(["a"] * 3000) + "]\n"
    with pytest.raises(ConfigError, match=r"tables are nested too deeply.*\[radio\]"):
        find_scenario(file(deep))
    with pytest.raises(ConfigError, match="scenario file"):
        find_scenario(file("x = " + "[" * 3000 + "]" * 3000 + "\n"))
