"""An extension of mkdocstrings: examples of docstrings become blocks of code."""

from typing import Any

import griffe


class DoctestFences(griffe.Extension):
    """Fences every paragraph that starts with `>>>`, which Markdown takes for a quotation."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Fence the examples of one docstring."""
        if obj.docstring is not None:
            obj.docstring.value = "\n\n".join(map(_fenced, obj.docstring.value.split("\n\n")))


def _fenced(paragraph: str) -> str:
    is_example = paragraph.lstrip().startswith(">>>")
    return f"```pycon\n{paragraph}\n```" if is_example else paragraph
