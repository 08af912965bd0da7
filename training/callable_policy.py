"""Policies as functions of Python's, by name: `callable:package.module:function`."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from training.policy import SHOWN_BY, PolicyFile, Predict
from training.policy_card import PolicyCard


class CallablePolicy(PolicyFile):
    """A function of Python's: callable:package.module:function.

    It maps what the robots of a world observe to their actions, both (robots, numbers). Its module
    is looked for on Python's path, and in the current folder. Importing it runs it.
    """

    @property
    def reads(self) -> tuple[Path, ...]:
        """The file of the module too."""
        file = getattr(sys.modules[self._function().__module__], "__file__", None)
        return (*SHOWN_BY, Path(file)) if file else SHOWN_BY

    def card(self) -> PolicyCard | None:
        """A function has none: its name says what it goes with."""
        return None

    def start(self, form: PolicyForm) -> Predict:
        """The function."""
        predict: Predict = self._function()
        return predict

    def _function(self) -> Any:  # noqa: ANN401 whatever the name stands for
        """What the name stands for; ConfigError if it is no function."""
        home, _, name = self.file.partition(":")
        if not name:
            raise ConfigError(
                f"callable '{self.file}': must be a module and a function, as in"
                " callable:package.module:function"
            )
        here = str(Path.cwd())
        if here not in sys.path:
            sys.path.append(here)
        try:
            found = getattr(import_module(home), name)
        except (ImportError, AttributeError) as error:
            raise ConfigError(f"callable '{self.file}': {error}") from None
        if not callable(found):
            raise ConfigError(f"callable '{self.file}': is a {type(found).__name__}, no function")
        return found
