"""Words of the glossary, linked to it where a page uses them first."""

import re
from collections.abc import Mapping

from typography import HEADS, changed

TERM = re.compile(r"^### (?P<words>.+?) \{ ?#(?P<anchor>[\w-]+) ?\}$", re.MULTILINE)
PLAIN = {"a", "code", *HEADS, "h5", "th", "figcaption"}
"""In these elements no word is linked."""


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


def linked(page: str, words: Mapping[str, str], glossary: str) -> str:
    """The HTML of a page, the first use of every word of the glossary a link to it.

    >>> linked("<p>The nest, the nest.</p>", {"nest": "nest"}, "glossary.html")
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
