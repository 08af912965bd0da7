"""Structured arrays, column by column: the gaps between the fields of a record hold anything."""


def columns(records, name):
    """Every plain array in structured arrays, those of nested records too, by dotted name."""
    if records.dtype.names is None:
        yield name, records
    else:
        for each in records.dtype.names:
            yield from columns(records[each], f"{name}.{each}")


def check_same_bits(one, other, name="records"):
    """Assert that two arrays, structured or plain, hold the same in every column, bit for bit."""
    assert one.dtype == other.dtype, name
    for (column, mine), (_, his) in zip(columns(one, name), columns(other, name), strict=True):
        assert mine.shape == his.shape, column
        assert mine.tobytes() == his.tobytes(), column
