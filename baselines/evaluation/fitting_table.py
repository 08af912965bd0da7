"""A table that fits a terminal: names of rows stay whole, and columns without room follow below."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from rich.cells import cell_len
from rich.console import Console, ConsoleOptions
from rich.table import Table
from rich.text import Text


@dataclass(frozen=True)
class FittingTable:
    """Columns of numbers beside the names of controllers, in as many tables as the width takes."""

    head: str
    """Heading of the names."""

    names: Sequence[str]
    """What each row is of."""

    columns: Mapping[str, Sequence[Text]]
    """Cells of each column by its heading, a cell for each name."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Table | Text]:
        """The tables, one below the other, each with the names of the rows."""
        names = self._names(options.max_width)
        for number, headings in enumerate(self._parts(options.max_width - _width(names))):
            if number:
                yield Text()
            yield self._table(names, headings)

    def _names(self, width: int) -> list[Text]:
        """The heading and the names, in one line each if all columns fit beside them."""
        names = [Text(name) for name in (self.head, *self.names)]
        if _width(names) + sum(map(self._column_width, self.columns)) <= width:
            return names
        return [in_lines(name) for name in (self.head, *self.names)]

    def _parts(self, room: int) -> list[list[str]]:
        """The headings of the columns that stand side by side."""
        parts: list[list[str]] = []
        left = 0
        for heading in self.columns:
            left -= self._column_width(heading)
            if left < 0 or not parts:
                parts.append([])
                left = room - self._column_width(heading)
            parts[-1].append(heading)
        return parts

    def _column_width(self, heading: str) -> int:
        return _width([Text(heading), *self.columns[heading]])

    def _table(self, names: Sequence[Text], headings: Sequence[str]) -> Table:
        table = Table(box=None, padding=(0, 1, 0, 0))
        table.add_column(names[0], overflow="fold")
        for heading in headings:
            table.add_column(Text(heading), justify="right", no_wrap=True)
        for row, name in enumerate(names[1:]):
            table.add_row(name, *(self.columns[heading][row] for heading in headings))
        return table


def in_lines(name: str) -> Text:
    """A controller's name, with its layers or parameters on lines below."""
    for mark, broken in ((":", ":\n "), (",", ",\n "), ("+", "\n +")):
        name = name.replace(mark, broken)
    return Text(name)


def _width(texts: Sequence[Text]) -> int:
    """Width of a column, with the space beside it."""
    return 1 + max(cell_len(line) for text in texts for line in text.plain.split("\n"))
