"""Links of a page that lead out of docs/: to pages of the site, or to pages that show a file."""

import posixpath
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

PAGES: Mapping[str, str] = {
    "README.md": "docs/index.md",
    "CONTRIBUTING.md": "docs/contributing.md",
    "CHANGELOG.md": "docs/changelog.md",
}
"""Files at the root that are pages of the site under another name."""

FOLDER = "docs/source"
"""Where the pages that show a file stand on the site."""

LINK = re.compile(r"(?P<before>\]\()(?P<target>[^)\s]+)(?P<after>\))")
LANGUAGES = {".py": "python", ".toml": "toml", ".yaml": "yaml", ".cff": "yaml", ".txt": "text"}


def page_of(file: str) -> str:
    """The page of the site that shows a file of the repository; both from its root.

    >>> page_of("examples/sb3_ppo.py")
    'docs/source/examples/sb3_ppo.py.md'
    >>> page_of("CHANGELOG.md")
    'docs/changelog.md'
    """
    return PAGES.get(file, file if file.startswith("docs/") else f"{FOLDER}/{file}.md")


def rewritten(markdown: str, origin: str, page: str) -> str:
    """A page's text, its links to files outside docs/ led to where the site shows them.

    `origin` is the file that the text stands in, `page` the page that it becomes.
    """

    def lead(match: re.Match[str]) -> str:
        path, anchor, is_file = _resolved(match["target"], origin)
        if not is_file:
            return match[0]
        target = posixpath.relpath(page_of(path), posixpath.dirname(page))
        return f"{match['before']}{target}{anchor}{match['after']}"

    return LINK.sub(lead, markdown)


def linked_files(markdown: str, origin: str) -> Iterator[str]:
    """The files outside docs/ that a text links to and that no page of the site is."""
    for match in LINK.finditer(markdown):
        path, _, is_file = _resolved(match["target"], origin)
        if is_file and page_of(path).startswith(FOLDER):
            yield path


def source_page(file: str) -> str:
    """A page that shows a file, its lines numbered so that a link can lead to one."""
    text = (ROOT / file).read_text(encoding="utf-8").rstrip()
    language = LANGUAGES.get(Path(file).suffix, "text")
    fence = "~~~~~~~~"
    head = f"---\nsearch:\n  exclude: true\n---\n\n# {file}\n"
    return f'{head}\n{fence} {{.{language} linenums="1"}}\n{text}\n{fence}\n'


def _resolved(target: str, origin: str) -> tuple[str, str, bool]:
    """The path from the root that a link leads to, its anchor, and whether it needs leading."""
    path, mark, anchor = target.partition("#")
    if not path or "://" in path or path.startswith(("mailto:", "/")):
        return "", "", False
    full = posixpath.normpath(posixpath.join(posixpath.dirname(origin), path))
    is_within = full.startswith("docs/") and origin.startswith("docs/")
    return full, mark + anchor, not is_within and (ROOT / full).is_file()
