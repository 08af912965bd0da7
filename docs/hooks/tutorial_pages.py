"""Tutorials: scripts in the percent format of jupytext, kept as notebooks with their outputs.

python docs/hooks/tutorial_pages.py [NAME ...]

runs the named scripts, or those whose kept notebook is of other code (`make tutorials`), and keeps
what they printed and drew in docs/tutorials. The site shows the kept notebooks and runs nothing.
"""

import os
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jupytext
import nbformat
from nbformat.v4 import new_code_cell

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "examples" / "tutorials"
KEPT = ROOT / "docs" / "tutorials"
RUN = "kept_run"
"""Where the metadata of a kept notebook say when it ran, and under which version."""

TEMPLATE = Path(__file__).parent / "templates" / "tutorial.md.j2"
"""Shows what cells printed in blocks of their own class."""

WHEEL = f"swarm_forage-{version('swarm-forage')}-py3-none-any.whl"
INSTALL = f"""# In Colab: upload {WHEEL}, which `make dist` makes, and run this cell first.
from importlib.util import find_spec

if find_spec("swarm_forage_env") is None:
    %pip install --quiet "{WHEEL}[train,render]\""""
"""The first cell of code of a notebook that is handed out."""


def script(name: str) -> Any:
    """The script of a tutorial as a notebook."""
    notebook = jupytext.read(SCRIPTS / f"{name}.py", fmt="py:percent")
    for k, cell in enumerate(notebook.cells):
        cell.id = f"{name}-{k}"
    return notebook


def code_cells(notebook: Any) -> list[Any]:
    """The cells of code of a notebook."""
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def is_current(name: str) -> bool:
    """Whether the kept notebook of a tutorial holds the code of its script."""
    kept = KEPT / f"{name}.ipynb"
    if not kept.is_file():
        return False
    both = nbformat.read(kept, as_version=4), script(name)
    there, here = ([cell.source for cell in code_cells(each)] for each in both)
    return there == here


def keep(name: str) -> None:
    """Run a tutorial at its full budget and keep it with its outputs."""
    from nbclient import NotebookClient

    notebook = script(name)
    resources = {"metadata": {"path": str(ROOT)}}
    NotebookClient(
        notebook, timeout=None, record_timing=False, resources=resources, kernel_name="python3"
    ).execute()
    for cell in code_cells(notebook):
        cell.outputs = _merged(cell.outputs)
    notebook.metadata = {
        "kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"},
        "language_info": {"name": "python", "file_extension": ".py"},
        RUN: {"date": f"{datetime.now(UTC):%Y-%m-%d}", "version": version("swarm-forage")},
    }
    nbformat.write(notebook, KEPT / f"{name}.ipynb")


def _merged(outputs: Sequence[Any]) -> list[Any]:
    """The outputs of a cell without what it wrote to stderr, pieces of a stream in one."""
    kept: list[Any] = []
    for each in outputs:
        if each.get("name") == "stderr" or not each.get("text", "-").strip():
            continue
        if kept and each.get("name") == "stdout" == kept[-1].get("name"):
            kept[-1].text += each.text
        else:
            kept.append(each)
    return kept


def page(name: str) -> tuple[str, dict[str, bytes]]:
    """The page of a kept notebook, and its pictures by their names."""
    from nbconvert import MarkdownExporter

    notebook = _read(name)
    title, *rest = notebook.cells
    notebook.cells = rest
    pictures = f"{name}_pictures"
    resources = {"unique_key": "picture", "output_files_dir": pictures}
    exporter = MarkdownExporter(raw_template=TEMPLATE.read_text(encoding="utf-8"))
    body, made = exporter.from_notebook_node(notebook, resources)
    made_by = "outputs of version {version}, {date}".format(**notebook.metadata[RUN])
    head = (
        f"[Script](../source/examples/tutorials/{name}.py.md) · "
        f"[notebook with outputs]({name}.ipynb) · {made_by}"
    )
    text = "\n\n".join([title.source, head, body])
    return text, {Path(uri).name: data for uri, data in made["outputs"].items()}


def handed_out(name: str) -> str:
    """The notebook with its outputs, which installs the wheel where it is run."""
    notebook = _read(name)
    notebook.cells.insert(1, new_code_cell(INSTALL, id=f"{name}-install"))
    return str(nbformat.writes(notebook))


def _read(name: str) -> Any:
    """The script as a notebook, with the outputs that are kept of its code."""
    if not is_current(name):
        raise SystemExit(f"tutorial {name}: what is kept of it is of other code: make tutorials")
    kept, notebook = nbformat.read(KEPT / f"{name}.ipynb", as_version=4), script(name)
    notebook.metadata = kept.metadata
    for cell, own in zip(code_cells(notebook), code_cells(kept), strict=True):
        cell.outputs = own.outputs
    return notebook


if __name__ == "__main__":
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    for chosen in sys.argv[1:] or sorted(path.stem for path in SCRIPTS.glob("*.py")):
        if chosen in sys.argv or not is_current(chosen):
            print(f"running {chosen}", flush=True)
            keep(chosen)
