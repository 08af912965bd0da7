"""A plug-in that cannot be imported leaves all others as they are, and says why it is missing."""

import sys
from importlib.metadata import EntryPoint, entry_points

import pytest

from swarm_forage_env import UnknownNameError, parallel_env, registry
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.registry import CONTROLLERS, PLUGIN_GROUP

NEEDS = "import nosuch", "(broken_swarm): 'nosuch' is missing"


@pytest.fixture
def plugin(tmp_path, monkeypatch):
    """Enter a plug-in of these lines, before those that are installed."""

    def enter(lines):
        (tmp_path / "broken_swarm.py").write_text(lines + "\n")
        points = [EntryPoint("broken", "broken_swarm", "any"), *entry_points(group=PLUGIN_GROUP)]
        monkeypatch.setattr(registry, "entry_points", lambda group: points)

    monkeypatch.setattr(registry, "_left_out", {})
    monkeypatch.syspath_prepend(tmp_path)
    yield enter
    sys.modules.pop("broken_swarm", None)


@pytest.mark.parametrize(
    ("lines", "why"),
    [
        NEEDS,
        ("import nosuch.below", "(broken_swarm): 'nosuch' is missing"),
        ("from math import nosuch", "cannot import name 'nosuch' from 'math'"),
        ("raise ImportError('not on this system')", "(broken_swarm): not on this system"),
        (
            "import safetensors.torch",
            "'safetensors.torch' is missing, pip install 'swarm-forage[evaluate]'",
        ),
        ("1 / 0", "(broken_swarm): ZeroDivisionError: division by zero"),
        ("raise SystemExit", "(broken_swarm): SystemExit"),
        ("def", "(broken_swarm): SyntaxError: invalid syntax (broken_swarm.py, line 1)"),
        (
            "import baselines.weighting as w; w.WEIGHTING_RULES.register('sgikf')(1)",
            "two weighting",
        ),
    ],
)
def test_the_reason_is_told_where_one_is_asked_for(plugin, command, monkeypatch, lines, why):
    monkeypatch.setitem(sys.modules, "safetensors.torch", None)
    plugin(lines)
    for ask in (find_controller, CONTROLLERS.__getitem__, ENGINES.__getitem__):
        with pytest.raises(UnknownNameError) as refusal:
            ask("none-such")
        assert "; left out: plug-in 'broken' (broken_swarm): " in str(refusal.value)
        assert why in str(refusal.value)
        assert "\n" not in str(refusal.value)
    assert command("list", "nc")[2] == f"swarm-forage: {registry.left_out()}\n"


def test_the_others_are_as_they_were(plugin):
    before = set(CONTROLLERS)
    plugin(NEEDS[0])
    assert set(CONTROLLERS) == before
    assert {"ssgikf", "learned-both"} <= before
    parallel_env("es1").reset(seed=0)


def test_it_is_tried_once_and_after_ours(plugin, monkeypatch):
    tried = []
    monkeypatch.setattr(EntryPoint, "load", lambda each: tried.append(each.value) or 1 / 0)
    plugin("")
    for _ in range(3):
        list(CONTROLLERS)
    assert tried.index("broken_swarm") > tried.index("training.controllers")
    assert tried.count("broken_swarm") == 1
