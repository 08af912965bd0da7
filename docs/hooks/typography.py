"""The text of a built page: where its lines may break, its links to decisions and to the glossary.

A line does not break between a number and its unit, nor inside a short name.
"""

import os
import re
from collections.abc import Callable, Collection, Mapping
from pathlib import Path

TAG = re.compile(r"(<[^>]+>)")
NAME = re.compile(r"</?([a-zA-Z][\w-]*)")
UNTOUCHED = {"pre", "script", "style", "svg", "math", "button", "label"}
"""In these elements nothing is changed."""

HEADS = "h1", "h2", "h3", "h4"

SPACE = "\N{NO-BREAK SPACE}"
NUMBER = r"-?\d[\d.,]*(?:e[-+]?\d+)?"
UNITS = r"%|s|ms|ns|min|h|m|cm|mm|rad|kB|MB|GB|M|M/s|Hz|V"
TOGETHER = (
    (re.compile(rf"({NUMBER}) to ({NUMBER})(?=[\s),;.]|$)"), rf"\1{SPACE}to{SPACE}\2"),
    (re.compile(rf"(\d) (?=(?:{UNITS})(?![\w/]))"), rf"\1{SPACE}"),
    (re.compile(rf"(&lt;|&gt;|=) (?={NUMBER}(?![\w(]))"), rf"\1{SPACE}"),
    (re.compile(r"(\d) us\b"), f"\\1{SPACE}\N{MICRO SIGN}s"),
    (re.compile(r"\d[\d.]*e-\d+"), r'<span class="whole">\g<0></span>'),
    (re.compile(r"\bx (?=\d)"), f"\N{MULTIPLICATION SIGN}{SPACE}"),
    (re.compile(r"\+- (?=\d)"), f"\N{PLUS-MINUS SIGN}{SPACE}"),
    (re.compile(rf"\b(p|n|g) (?=(?:&lt;|=){SPACE})"), rf"\1{SPACE}"),
)
"""What is looked for in prose, and what stands for it."""

WHOLE = 28
"""Names of at most so many letters are never broken."""

MARK = re.compile(r"[._:,=/+](?=[^\W\d])")
"""Where a longer name may be broken: before a letter."""

HEADING = re.compile(rf'(<span class="doc doc-object-name[^"]*">)([^<]{{{WHOLE + 1},}})')
"""The name of what a part of the reference is about."""

DECISION = re.compile(r"\b[Dd]ecision (\d{4})\b")

TERM = re.compile(r"^### (?P<words>.+?) \{ ?#(?P<anchor>[\w-]+) ?\}$", re.MULTILINE)
PLAIN = {"a", "code", *HEADS, "h5", "th", "figcaption"}
"""In these elements no word is linked."""


def set_lines(page: str) -> str:
    """The HTML of a page with its numbers, units, options and short names in one line each.

    >>> set_lines("<p>in 313 MB (57 to 63), p &lt; 0.01</p>").replace(SPACE, "~")
    '<p>in 313~MB (57~to~63), p~&lt;~0.01</p>'
    >>> set_lines("<p><code>a --select 3</code></p>")
    '<p><code>a <span class="whole">--select</span> 3</code></p>'
    >>> set_lines("<code>baselines.weighting.sgikf.SGIKF</code>")
    '<code>baselines.<wbr>weighting.<wbr>sgikf.<wbr>SGIKF</code>'
    """

    def set_line(text: str, path: list[str]) -> str:
        return _code(text, "td" not in path) if "code" in path else _prose(text)

    return changed(page, set_line)


def break_headings(page: str) -> str:
    """The HTML of a page of the reference whose long names in headings break at their marks.

    >>> break_headings(
    ...     '<span class="doc doc-object-name">training.ppo_learner.hyperparameters</span>'
    ... )
    '<span class="doc doc-object-name">training.<wbr>ppo_<wbr>learner.<wbr>hyperparameters</span>'
    """
    return HEADING.sub(lambda match: match[1] + _word(match[2]), page)


def link_decisions(page: str, folder: Path, uri: str) -> str:
    """The HTML of a page whose mentions of a decision, as "decision 0012", are links to it."""
    pages = {path.name[:4]: path.stem for path in folder.glob("[0-9]*.md")}
    here = os.path.dirname(uri)

    def link(match: re.Match[str]) -> str:
        if match[1] not in pages or Path(uri).stem == pages[match[1]]:
            return match[0]
        target = os.path.relpath(f"decisions/{pages[match[1]]}.html", here or ".")
        return f'<a href="{target}">{match[0]}</a>'

    return changed(page, lambda text, _: DECISION.sub(link, text), {"a", "code", *HEADS})


def terms(glossary: str) -> dict[str, str]:
    """Every word of the glossary, in small letters, and its anchor; symbols of one letter left out.

    >>> terms("### Round trip, trip {#round-trip}")
    {'round trip': 'round-trip', 'trip': 'round-trip'}
    """
    return {
        word.strip("` ").lower(): match["anchor"]
        for match in TERM.finditer(glossary)
        for word in match["words"].split(",")
        if len(word) > 1
    }


def link_terms(page: str, words: Mapping[str, str], glossary: str) -> str:
    """The HTML of a page, the first use of every word of the glossary a link to it.

    >>> link_terms("<p>The nest, the nest.</p>", {"nest": "nest"}, "glossary.html")
    '<p>The <a class="term" href="glossary.html#nest">nest</a>, the nest.</p>'
    """
    if not words:
        return page
    longest_first = sorted(words, key=len, reverse=True)
    pattern = re.compile(
        r"(?<![\w-])(" + "|".join(map(re.escape, longest_first)) + r")(?P<s>s?)(?![\w-])", re.I
    )
    seen: set[str] = set()

    def link(match: re.Match[str]) -> str:
        anchor = words[match[1].lower()]
        if anchor in seen:
            return match[0]
        seen.add(anchor)
        return f'<a class="term" href="{glossary}#{anchor}">{match[0]}</a>'

    return changed(page, lambda text, _: pattern.sub(link, text), PLAIN)


def changed(
    page: str, change: Callable[[str, list[str]], str], besides: Collection[str] = ()
) -> str:
    """A page with its text changed, but in `UNTOUCHED` elements and some `besides`.

    A change is given a text and the elements around it.
    """
    path: list[str] = []
    pieces = TAG.split(page)
    for k, piece in enumerate(pieces):
        if piece.startswith("<"):
            _enter_or_leave(piece, path)
        elif not UNTOUCHED.union(besides).intersection(path):
            pieces[k] = change(piece, path)
    return "".join(pieces)


def _enter_or_leave(tag: str, path: list[str]) -> None:
    name = NAME.match(tag)
    if name is None or tag.endswith("/>"):
        return
    if not tag.startswith("</"):
        path.append(name[1].lower())
    elif name[1].lower() in path:
        while path.pop() != name[1].lower():
            pass


def _prose(text: str) -> str:
    for pattern, replacement in TOGETHER:
        text = pattern.sub(replacement, text)
    return text


def _code(text: str, is_wide: bool) -> str:
    """Code whose words are in one line each; in a cell of a table, long ones break anywhere."""
    words = re.split(r"(\s+)", text)
    return "".join(_word(each) if is_wide or len(each) <= WHOLE else each for each in words)


def _word(word: str) -> str:
    """A word of code in one line; a long one, as `package.module.function`, breaks at its marks."""
    if len(word) > WHOLE:
        return MARK.sub(r"\g<0><wbr>", word)
    return f'<span class="whole">{word}</span>' if re.search(r"[-./\[:]", word) else word
