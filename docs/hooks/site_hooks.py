"""What MkDocs does beyond Markdown: generated pages, links to sources, links to the glossary.

Generated pages are made from the code at every build and kept nowhere, so that none is out of date.
"""

import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import cards
import make_equations
import reference_pages
import source_pages
import tutorial_pages
import typography
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = source_pages.ROOT
GLOSSARY = "glossary.md"
REPLAYS = ROOT / "build" / "replays"
ORDER = (
    "first_swarm", "train_in_20_lines", "reproduce_a_figure", "watch_and_compare", "read_the_data",
    "learn_a_motion", "learn_a_weighting", "a_rule_as_a_package", "task_in_one_file", "scale_out",
    "a_thousand_worlds_on_a_gpu", "onto_a_cortex_m4",
)  # fmt: skip
"""The tutorials in the order of the navigation."""

Pages = dict[str, tuple[str, str]]
"""Generated pages by their place: the file that each stands for, and its text."""


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Enter the generated pages into the navigation."""
    for section in config.nav:
        (title, entries), *_ = section.items()
        if title == "Environments":
            entries += cards.navigation()
        if title == "Tutorials":
            entries += [f"tutorials/{name}.md" for name in ORDER]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages, then one for each source file that any page links to."""
    pages = {
        "contributing.md": ("CONTRIBUTING.md", _read("CONTRIBUTING.md")),
        "changelog.md": ("CHANGELOG.md", _read("CHANGELOG.md")),
        "equations.md": ("docs/equations.md", make_equations.typeset_page(ROOT)),
        **{uri: (f"docs/{uri}", text) for uri, text in cards.pages().items()},
    }
    pages |= _tutorials(files, config) | _reference(files)
    linked = {f"examples/tutorials/{name}.py" for name in ORDER}
    for uri, (origin, text) in pages.items():
        linked |= set(source_pages.linked_files(text, origin))
        _add(files, config, uri, source_pages.rewritten(text, origin, f"docs/{uri}"))
    for file in files.documentation_pages():
        if file.src_uri not in pages:
            linked |= set(source_pages.linked_files(file.content_string, f"docs/{file.src_uri}"))
    for path in sorted(linked):
        _add(files, config, f"source/{path}.md", source_pages.source_page(path))
    for replay in sorted(REPLAYS.glob("*.html")):
        _add(files, config, f"replays/{replay.name}", replay.read_text(encoding="utf-8"))
    return files


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Lead links to files outside docs/ to the pages that show them."""
    origin = f"docs/{page.file.src_uri}"
    if page.file.src_uri.startswith("reference/") and page.file.generated_by is None:
        markdown = reference_pages.with_tables(markdown)
    markdown = markdown.replace("<!-- keywords -->", reference_pages.keywords())
    return source_pages.rewritten(markdown, origin, origin)


def on_page_content(html: str, page: Page, config: MkDocsConfig, **_: object) -> str:
    """Link first uses of the words of the glossary, and equations to the lines of their code."""
    if page.file.src_uri.startswith("source/"):
        return html
    if page.file.src_uri.startswith("reference/"):
        return typography.break_headings(html)
    html = typography.set_lines(html)
    if page.file.src_uri == "equations.md":
        return make_equations.with_lines(html)
    decisions = Path(config.docs_dir) / "decisions"
    html = typography.link_decisions(html, decisions, page.file.dest_uri)
    if page.file.src_uri == GLOSSARY:
        return html
    words = typography.terms((Path(config.docs_dir) / GLOSSARY).read_text(encoding="utf-8"))
    target = os.path.relpath("glossary.html", Path(page.file.dest_uri).parent)
    return typography.link_terms(html, words, target)


def _tutorials(files: Files, config: MkDocsConfig) -> Pages:
    """A page for each tutorial; its pictures and its notebook are added at once."""
    pages = {}
    for name in ORDER:
        text, pictures = tutorial_pages.page(name)
        pages[f"tutorials/{name}.md"] = (f"docs/tutorials/{name}.md", text)
        _add(files, config, f"tutorials/{name}.ipynb", tutorial_pages.handed_out(name))
        for picture, content in pictures.items():
            _add(files, config, f"tutorials/{name}_pictures/{picture}", content)
    return pages


def _reference(files: Files) -> Pages:
    """A page for each name of the reference."""
    pages = {}
    for index in reference_pages.INDEXES:
        file = files.get_file_from_path(f"reference/{index}.md")
        assert file is not None, index
        for name in reference_pages.names(file.content_string):
            text = reference_pages.page(name, index)
            pages[f"reference/{name}.md"] = (f"docs/reference/{index}.md", text)
    return pages


def _read(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def _add(files: Files, config: MkDocsConfig, uri: str, content: str | bytes) -> None:
    """Add a generated file, in the place of one of the same name."""
    if (old := files.get_file_from_path(uri)) is not None:
        files.remove(old)
    files.append(File.generated(config, uri, content=content))
