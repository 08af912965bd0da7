"""The two built-in tasks are known to whoever asks, without an import of their own."""

import pytest

from tests.scripts import run_python


@pytest.mark.parametrize(
    "question",
    [
        "from swarm_forage_env.task import TASKS; TASKS['foraging']; TASKS['waypoints']",
        "from swarm_forage_env.registry import SCENARIOS; SCENARIOS['waypoints-05']",
        "from swarm_forage_env.registry import SCENARIOS; SCENARIOS['es1']",
    ],
)
def test_what_is_built_in_is_there_when_it_is_asked_for(question):
    run_python("-c", question)
