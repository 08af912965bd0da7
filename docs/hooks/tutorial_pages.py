"""Tutorials: scripts in the percent format of jupytext, as pages and as notebooks."""

import re
from importlib.metadata import version
from pathlib import Path

WHEEL = f"swarm_forage-{version('swarm-forage')}-py3-none-any.whl"

INSTALL = f"""# In Colab: upload {WHEEL}, which `make dist` makes, and run this cell first.
from importlib.util import find_spec

if find_spec("swarm_forage_env") is None:
    %pip install --quiet "{WHEEL}[train,render]\""""
"""The first cell of code of a notebook."""

CELL = re.compile(r"^# %%(?P<kind> \[markdown\])?.*$", re.MULTILINE)


def page(script: str, name: str) -> str:
    r"""The page of a script: its comments as text, its code in blocks.

    >>> print(page("# %% [markdown]\n# # First\n#\n# Words.\n# %%\nx = 1\n", "first"))
    # First
    <BLANKLINE>
    Words.
    <BLANKLINE>
    [Script](../source/examples/tutorials/first.py.md) · [notebook](first.ipynb)
    <BLANKLINE>
    ```python
    x = 1
    ```
    <BLANKLINE>
    """
    _, *pieces = CELL.split(script)
    parts = []
    for kind, body in zip(pieces[::2], pieces[1::2], strict=True):
        text = body.strip("\n")
        if kind:
            parts.append("\n".join(re.sub(r"^# ?", "", line) for line in text.splitlines()))
        elif text:
            parts.append(f"```python\n{text}\n```")
    links = f"[Script](../source/examples/tutorials/{name}.py.md) · [notebook]({name}.ipynb)"
    return "\n\n".join([parts[0], links, *parts[1:]]) + "\n"


def notebook(script: Path) -> str:
    """The notebook of a script, as jupytext writes it, which installs the wheel where it is run."""
    import jupytext
    from nbformat.v4 import new_code_cell

    found = jupytext.read(script, fmt="py:percent")
    found.cells.insert(1, new_code_cell(INSTALL))
    return str(jupytext.writes(found, fmt="ipynb"))
