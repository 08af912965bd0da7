"""Offline transitions: what robots observed, did and earned in every tick, read from Parquet.

    OUT/scenario=es1/policy=ssgikf/<key>-seed00010000.transitions.parquet

`swarm-forage dataset` writes them, `training.transition_recording` makes them.
"""

from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pyarrow as pa

from baselines.evaluation.dataset import DamagedFileError, checked_text, read_table, unread
from swarm_forage_env.arrays import Array
from swarm_forage_env.errors import ConfigError
from training.policy_card import PolicyCard, card_from

ENDING = ".transitions.parquet"
"""Of the names of files."""

CARD = b"card"
"""Metadata key of the card that a policy which is trained on a file has."""

COLUMNS = (
    "observation", "action", "reward", "next_observation", "terminated", "truncated",
    "robot", "decision", "seed",
)  # fmt: skip


def read(folder: str | Path, policy: str | None = None) -> dict[str, Array]:
    """The transitions in a folder, of one policy or of all, by the names of `COLUMNS` and `policy`.

        from training.transitions import read

        played = read("runs/es1-transitions", "ssgikf")
        played["observation"], played["action"]          # float32, (rows, numbers)

    The transitions of a robot in an episode follow one another, and `truncated` ends them.
    ConfigError for a folder without any, with an episode in two versions or with several action
    spaces or observations, and for a damaged file.

    Args:
        folder: What `swarm-forage dataset` has written.
        policy: The name of one policy; None: all.
    """
    files = _files(Path(folder), policy)
    tables, cards = zip(*map(_kept_in, files), strict=True)
    if len({(card.keywords.model_dump_json(), card.observes) for card in cards}) > 1:
        raise ConfigError(
            f"transitions {folder}: of policies that do not observe and act alike; record each"
            " scenario into a folder of its own"
        )
    rows = [len(table) for table in tables]
    names = np.repeat(np.array([_policy_of(file) for file in files], object), rows)
    whole = pa.concat_tables([table.replace_schema_metadata() for table in tables])
    return {name: _array(whole[name]) for name in COLUMNS} | {"policy": names}


def card_in(folder: str | Path, policy: str) -> PolicyCard:
    """The card of a policy that is trained on the transitions of this one; errors as `read`."""
    file, *_ = _files(Path(folder), policy)
    return _kept_in(file)[1]


def _files(folder: Path, policy: str | None) -> list[Path]:
    found: dict[tuple[Path, str], Path] = {}
    for file in sorted(folder.glob(f"scenario=*/policy=*/*{ENDING}")):
        episode = file.parent, file.name.rpartition("-")[2]
        if policy not in (None, _policy_of(file)):
            continue
        if episode in found:
            raise ConfigError(
                f"transitions {folder}: {found[episode].name} and {file.name} are one episode under"
                " other numbers or another version of the code; remove one, or record again into"
                " another folder"
            )
        found[episode] = file
    if not found:
        what = "none" if policy is None else f"none of policy '{policy}'"
        raise ConfigError(
            f"transitions {folder}: holds {what}; record some with swarm-forage dataset es1"
            f" {policy or 'ssgikf'} --out {folder}"
        )
    return list(found.values())


def _policy_of(file: Path) -> str:
    return unquote(file.parent.name.partition("=")[2])


def _kept_in(file: Path) -> tuple[pa.Table, PolicyCard]:
    """The transitions and the card in a file; ConfigError if it is damaged."""
    try:
        table = read_table(file.read_bytes())
        return table, card_from(card_text(table), str(file))
    except (DamagedFileError, OSError) as damage:
        raise unread(f"transitions {file}", damage) from None


def card_text(table: pa.Table) -> str:
    """The card in a file's metadata, as JSON; DamagedFileError if there is none."""
    return checked_text((table.schema.metadata or {}).get(CARD, b""))


def _array(column: pa.ChunkedArray) -> Array:
    whole = column.combine_chunks()
    if pa.types.is_fixed_size_list(whole.type):
        return np.array(whole.flatten()).reshape(len(whole), -1)
    return np.array(whole)
