"""Algorithms of the ladder: each a file of settings, tuned on no rung of its own."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Literal

import yaml
from pydantic import Field

from swarm_forage_env.errors import UnknownNameError
from swarm_forage_env.parameters import Count, Part, Positive, validated

FOLDER = Path(__file__).parent


class Algorithm(Part):
    """What is trained, by which library, under which settings."""

    name: str = Field("", description="That of its file")
    title: str = Field("", description="Its name on figures and pages")
    trainer: Literal["sb3", "benchmarl"] = Field("sb3", description="The library that trains it")
    algorithm: str = Field("", description="Its name in BenchMARL")
    worlds: Count = Field(8, description="Worlds side by side (sb3)")
    settings: Mapping[str, Any] = Field(
        default_factory=dict, description="Keywords of PPO, or of BenchMARL's algorithm"
    )
    experiment: Mapping[str, Any] = Field(
        default_factory=dict, description="Settings of BenchMARL's experiment that differ"
    )
    keywords: Mapping[str, Any] = Field(
        default_factory=dict, description="Of `parallel_env` in training that differ"
    )
    share: Positive = Field(1.0, description="Of a rung's robot-steps, for a slow one")


@cache
def read_algorithms(folder: Path = FOLDER) -> dict[str, Algorithm]:
    """The algorithms of a folder by name."""
    found = {}
    for file in sorted(folder.glob("*.yaml")):
        tree = {**yaml.safe_load(file.read_text(encoding="utf-8")), "name": file.stem}
        found[file.stem] = validated(Algorithm, tree, str(file))
    return found


def title_of(algorithm: str) -> str:
    """The name of an algorithm on figures and pages."""
    return read_algorithms()[algorithm].title


def find_algorithms(names: Sequence[str] | None) -> list[Algorithm]:
    """The algorithms of these names, all without names; UnknownNameError for a name of none."""
    known = read_algorithms()
    for name in names or ():
        if name not in known:
            raise UnknownNameError("algorithm", name, known)
    return [each for name, each in known.items() if not names or name in names]
