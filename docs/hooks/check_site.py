"""Check a built site: every link leads somewhere in it, and nothing is fetched from elsewhere.

python docs/hooks/check_site.py site
"""

import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

FETCHED_RELATIONS = {"stylesheet", "icon", "preload", "preconnect", "dns-prefetch", "prefetch"}
FROM_ELSEWHERE = re.compile(r"(?:url\(|@import)\s*[\"']?(?:https?:)?//", re.IGNORECASE)


class Page(HTMLParser):
    """The anchors of a page, its links, and what a browser fetches to show it."""

    def __init__(self, text: str) -> None:
        """Read a page."""
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.assets: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note anchors, links and assets."""
        found = {name: value or "" for name, value in attrs}
        self.anchors |= {found[name] for name in ("id", "name") if name in found}
        if tag == "a" and "href" in found:
            self.links.append(found["href"])
        if "src" in found:
            self.assets.append(found["src"])
        if tag == "link" and FETCHED_RELATIONS & set(found.get("rel", "").split()):
            self.assets.append(found["href"])


def faults(site: Path) -> Iterator[str]:
    """One line for each fault of a site."""
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    for path, page in pages.items():
        where = path.relative_to(site)
        for target in (*page.links, *page.assets):
            parts = urlsplit(target)
            if parts.netloc or parts.scheme not in ("", "data"):
                if target in page.assets:
                    yield f"{where}: fetches {target}"
            elif fault := _missing(target, path, site, pages):
                yield f"{where}: {fault}"
    for path in sorted(site.rglob("*.css")):
        if FROM_ELSEWHERE.search(path.read_text(encoding="utf-8")):
            yield f"{path.relative_to(site)}: fetches from elsewhere"


def _missing(target: str, origin: Path, site: Path, pages: dict[Path, Page]) -> str:
    """What is wrong with a link within the site; empty if nothing."""
    parts = urlsplit(target)
    if parts.scheme == "data":
        return ""
    base = site if parts.path.startswith("/") else origin.parent
    path = (base / unquote(parts.path).lstrip("/")).resolve() if parts.path else origin
    if path.is_dir():
        path /= "index.html"
    if not path.is_file() or site.resolve() not in path.resolve().parents:
        return f"dead link {target}"
    anchor = unquote(parts.fragment)
    known = pages.get(path)
    is_state = "=" in anchor  # of a playground, which reads its address itself
    is_alive = not anchor or is_state or known is None or anchor in known.anchors
    return "" if is_alive else f"dead anchor {target}"


if __name__ == "__main__":
    folder = Path(sys.argv[1]).resolve()
    found = list(faults(folder))
    if found:
        sys.exit("\n".join(found))
