"""The page of equations on the site: each typeset, beside its function and its source."""

import html
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path

import make_equations
from equation_markup import NotationError, equations, to_latex
from latex2mathml.converter import convert

HEAD = """\
# Equations

Which function implements which equation of which paper. The equations are those of the docstrings,
set in type; a function whose source is a section rather than an equation often has none. The same
list without equations, as plain Markdown, is `docs/equations.md`, written by `make docs-equations`.
"""


def page(root: Path) -> str:
    """The page, from the docstrings of the packages."""
    found = sorted(make_equations.entries(root), key=make_equations.Entry.order)
    parts = [HEAD]
    for paper, title in {**make_equations.PAPERS, make_equations.OTHER: ""}.items():
        own = [entry for entry in found if entry.paper == paper]
        if not own:
            continue
        parts.append(f"## {paper}\n\n{title + '.' if title else ''}\n")
        for entry in own:
            link = f"[`{entry.name}`](../{entry.file}){{ .line-{entry.line} }}"
            says = html.escape(entry.says, quote=False)
            parts.append(
                f'<div class="equation" markdown>\n\n**{entry.place or "-"}** {link} {says}.\n\n'
                + "".join(map(_typeset, _indented(entry.docstring)))
                + "\n</div>\n"
            )
    return "\n".join(parts)


def with_lines(page: str) -> str:
    """The built page, each link to a source led to the line of its function.

    >>> with_lines('<a class="line-7" href="source/x.py.html">')
    '<a href="source/x.py.html#__codelineno-0-7">'
    """
    return re.sub(r'<a class="line-(\d+)" href="([^"]+)"', r'<a href="\2#__codelineno-0-\1"', page)


def _indented(docstring: str) -> Iterator[str]:
    """The blocks of a docstring that are set off, and hold an equation."""
    for paragraph in docstring.split("\n\n"):
        if paragraph.startswith("    ") and "=" in paragraph:
            yield textwrap.dedent(paragraph)


def _typeset(block: str) -> str:
    """The equations of a block as MathML, which browsers show without a script."""
    shown = []
    for each in equations(block):
        try:
            shown.append(convert(to_latex(each), display="block"))
        except NotationError:
            shown.append(f"<pre><code>{html.escape(each)}</code></pre>")
    return "<div class='math'>" + "".join(shown) + "</div>\n"
