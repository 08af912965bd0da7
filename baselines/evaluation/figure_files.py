"""The files of a figure: the picture, with its caption in the metadata, and a JSON file beside."""

import json
from dataclasses import replace
from io import BytesIO
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from baselines.evaluation.figure_page import Caption, CaptionedFigure
from baselines.evaluation.output_files import check_file
from swarm_forage_env.atomic_write import write_atomically

FORMATS = {".png": "Description", ".pdf": "Subject", ".svg": "Description"}
"""Endings of a figure's file, and the field of its metadata that holds the caption."""


def check_plot(file: Path, option: str = "--plot") -> None:
    """Raise ConfigError unless a figure can be written to this file; its folder is made."""
    check_file(option, file, FORMATS)


def save_figure(figure: Figure, file: Path, command: str, title: str = "Round trips") -> None:
    """Write a figure to a file, whole or not at all, and its caption beside it (`x.png.json`).

    The metadata of the file hold the caption with the command, and no date.
    """
    caption = figure.caption if isinstance(figure, CaptionedFigure) else Caption()
    caption = replace(caption, command=caption.command or command)
    ending, content = file.suffix.lower(), BytesIO()
    metadata: dict[str, str | None] = {FORMATS[ending]: str(caption), "Title": title}
    if ending == ".pdf":
        metadata["CreationDate"] = None
    if ending == ".svg":
        metadata["Date"] = None
    with rc_context({"svg.hashsalt": "swarm-forage", "svg.fonttype": "none", "pdf.fonttype": 42}):
        figure.savefig(content, format=ending[1:], dpi=200, metadata=metadata)
    write_atomically(file, content.getvalue())
    write_atomically(beside(file), _to_json(caption, title))


def beside(file: Path) -> Path:
    """The JSON file of a figure's file."""
    return file.with_name(f"{file.name}.json")


def _to_json(caption: Caption, title: str) -> bytes:
    tree = {
        "title": title,
        "text": caption.text,
        "note": caption.note,
        "command": caption.command,
        "code": list(caption.code),
    }
    return (json.dumps(tree, indent=1) + "\n").encode()
