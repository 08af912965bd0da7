"""Which function implements which equation of which paper: docs/equations.md, and a typeset page.

Every docstring under the packages may hold lines such as

    Source: TR, Eq. 33; ANTS, Eq. 3.

A citation runs to the blank line below it, several are separated by semicolons. The code is
parsed, never imported.
"""

import ast
import html
import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from equation_markup import NotationError, equations, to_latex

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("swarm_forage_env", "baselines")
PAPERS = {
    "TR": "Gutiérrez et al. (2009), *Social Odometry: A Self-Organized Distributed Location"
    " Algorithm*, TR/IRIDIA/2009-014",
    "ANTS": "Gutiérrez et al. (2008), *Social Odometry in Populations of Autonomous Robots*,"
    " ANTS 2008",
    "BOIDS": "Smith et al. (2021), *Cooperative and Coordinated Localization of Swarm Robots"
    " using Adaptive Boids Rules*",
}
OTHER = "Other sources"
HEAD = """\
<!-- Made by `make docs-equations` from the `Source:` lines of the docstrings: edit those. -->

# Equations and where they live
"""

TYPESET_HEAD = """\
# Equations

Which function implements which equation of which paper. The equations are those of the docstrings,
set in type; a function whose source is a section rather than an equation often has none. The same
list without equations, as plain Markdown, is `docs/equations.md`, written by `make docs-equations`.
"""

CITATION = re.compile(rf"(?P<paper>{'|'.join(PAPERS)})\b[,\s]*(?P<place>.*)")
SENTENCE = re.compile(r"(.+?)\.(?:\s|$)")
Documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True)
class Entry:
    """One citation by one function, class or module."""

    paper: str
    place: str
    name: str
    file: str
    line: int
    docstring: str

    @property
    def says(self) -> str:
        """The first sentence of the docstring."""
        return first_sentence(self.docstring)

    def order(self) -> tuple[int, bool, list[tuple[int, str]], str]:
        """By paper, equations before sections, numbers as numbers."""
        papers = [*PAPERS, OTHER]
        is_prose = not self.place.startswith("Eq")
        return papers.index(self.paper), is_prose, _natural(self.place), self.name

    def row(self) -> str:
        """The entry as a row of a Markdown table."""
        cells = self.place or "-", f"[`{self.name}`](../{self.file})", self.says
        return "| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |"


def _natural(text: str) -> list[tuple[int, str]]:
    """Sort key under which Eq. 9 comes before Eq. 10."""
    return [(int(part), "") if part.isdigit() else (0, part) for part in re.split(r"(\d+)", text)]


def citations(docstring: str) -> Iterator[tuple[str, str]]:
    """Paper and place of every citation in a docstring.

    >>> list(citations("Blend.\\n\\nSource: TR, Eq. 33;\\n    ANTS, Eq. 3.\\n\\nMore."))
    [('TR', 'Eq. 33'), ('ANTS', 'Eq. 3')]
    >>> list(citations("Blend.\\n\\nSource: textbook (scalar Kalman gain)."))
    [('Other sources', 'textbook (scalar Kalman gain)')]
    """
    for paragraph in docstring.split("\n\n"):
        _, *sources = re.split(r"^\s*Source:", paragraph, flags=re.MULTILINE)
        for source in sources:
            for citation in " ".join(source.split()).rstrip(".").split("; "):
                match = CITATION.match(citation)
                yield (match["paper"], match["place"]) if match else (OTHER, citation)


def first_sentence(docstring: str) -> str:
    """The first sentence of the first paragraph.

    >>> first_sentence("A robot is 0.07 m\\nwide. It has two wheels.")
    'A robot is 0.07 m wide'
    """
    paragraph = " ".join(docstring.split("\n\n", 1)[0].split())
    match = SENTENCE.match(paragraph)
    return match[1] if match else paragraph


def documented(tree: ast.Module, module: str) -> Iterator[tuple[str, int, str]]:
    """Dotted name, line and docstring of a module and of everything documented inside it."""
    pending: list[tuple[str, Documented]] = [(module, tree)]
    while pending:
        name, node = pending.pop(0)
        if docstring := ast.get_docstring(node):
            yield name, getattr(node, "lineno", 1), docstring
        pending += [
            (f"{name}.{child.name}", child) for child in node.body if isinstance(child, Documented)
        ]


def entries(root: Path) -> Iterator[Entry]:
    """Every citation in the packages under a root."""
    for path in sorted(p for package in PACKAGES for p in (root / package).rglob("*.py")):
        relative = path.relative_to(root)
        module = ".".join(relative.with_suffix("").parts).removesuffix(".__init__")
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for name, line, docstring in documented(tree, module):
            for paper, place in citations(docstring):
                yield Entry(paper, place, name, relative.as_posix(), line, docstring)


def by_paper(root: Path) -> Iterator[tuple[str, list[Entry]]]:
    """The heading of each paper that is cited, and its citations in order."""
    found = sorted(entries(root), key=Entry.order)
    for paper, title in {**PAPERS, OTHER: ""}.items():
        if own := [entry for entry in found if entry.paper == paper]:
            yield f"## {paper}\n" + (f"\n{title}.\n" if title else ""), own


def page(root: Path) -> str:
    """The whole of docs/equations.md."""
    lines = [HEAD]
    for heading, own in by_paper(root):
        rows = (entry.row() for entry in own)
        lines += [heading, "| where | code | what |", "|---|---|---|", *rows, ""]
    return "\n".join(lines)


def typeset_page(root: Path) -> str:
    """The page of the site: each equation typeset, beside its function and its source."""
    parts = [TYPESET_HEAD]
    for heading, own in by_paper(root):
        parts.append(heading)
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
    from latex2mathml.converter import convert

    shown = []
    for each in equations(block):
        try:
            shown.append(convert(to_latex(each), display="block"))
        except NotationError:
            shown.append(f"<pre><code>{html.escape(each)}</code></pre>")
    return "<div class='math'>" + "".join(shown) + "</div>\n"


if __name__ == "__main__":
    (ROOT / "docs" / "equations.md").write_text(page(ROOT), encoding="utf-8")
