"""An extension of mkdocstrings: examples of docstrings become blocks of code, and lists lists."""

import re

import griffe


class DoctestFences(griffe.Extension):
    """Fences every paragraph that starts with `>>>`, which Markdown takes for a quotation.

    A list that follows a sentence at once is set apart, as Markdown asks.
    """

    def on_object(self, *, obj: griffe.Object, **_: object) -> None:
        """Fence the examples of one docstring."""
        if obj.docstring is not None:
            obj.docstring.value = "\n\n".join(map(_fenced, obj.docstring.value.split("\n\n")))


def _fenced(paragraph: str) -> str:
    is_example = paragraph.lstrip().startswith(">>>")
    if is_example:
        return f"```pycon\n{paragraph}\n```"
    return re.sub(r":\n- ", ":\n\n- ", paragraph)
