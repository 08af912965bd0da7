"""Tutorials: scripts in the percent format of jupytext, as pages and as notebooks."""

import re
from pathlib import Path

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
    """The notebook of a script, as jupytext writes it."""
    import jupytext

    return str(jupytext.writes(jupytext.read(script, fmt="py:percent"), fmt="ipynb"))
