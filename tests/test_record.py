"""Records: documented fields from which structured arrays are made."""

import numpy as np
import pytest

from swarm_forage_env.arrays import Array, Float64, Int8
from swarm_forage_env.compiler import kernel
from swarm_forage_env.record import Record, field, one_record, record_dtype
from tests.columns import check_same_bits, columns


class Wheel(Record):
    speed: float = field(np.float64, unit="m/s", scale=0.1)
    is_stuck: bool = field(np.bool_)


class Vehicle(Record):
    pose: Float64[Array, "3"] = field(np.float64, 3, unit="m, m, rad")
    goal: int = field(np.int8, start=-1)
    left: Wheel = field(Wheel)
    right: Wheel = field(Wheel)
    met: Int8[Array, "slots 2"] = field(np.int8, "slots", 2, start=7)


class Lorry(Vehicle):
    load: float = field(np.float32, unit="kg", scale=1e3, start=2.5)


def test_records_are_compared_by_the_bits_of_their_fields_whatever_the_gaps_hold():
    dtype = Vehicle.dtype(slots=1)
    one, other = (np.full(dtype.itemsize, byte, np.uint8).view(dtype) for byte in (0, 255))
    for _, column in (*columns(one, "one"), *columns(other, "other")):
        column[...] = np.nan if column.dtype.kind == "f" else 1
    assert one.tobytes() != other.tobytes()
    check_same_bits(one, other)
    one["left"]["speed"], other["left"]["speed"] = 0.0, -0.0
    with pytest.raises(AssertionError, match=r"records\.left\.speed"):
        check_same_bits(one, other)


@pytest.mark.parametrize("slots", [0, 3])
def test_a_dtype_has_aligned_fields_in_their_order_those_of_base_classes_last(slots):
    dtype = Lorry.dtype(slots=slots, robots=5)  # of an axis that it does not have
    assert dtype.names == ("load", "pose", "goal", "left", "right", "met")
    assert dtype["pose"] == np.dtype((np.float64, (3,)))
    assert dtype["goal"] == np.int8
    assert dtype["left"].names == ("speed", "is_stuck")
    assert dtype["met"].shape == (slots, 2)
    assert dtype.isalignedstruct
    assert dtype["left"].isalignedstruct
    assert dtype.fields["left"][1] % np.dtype(np.float64).alignment == 0
    assert Vehicle.dtype(slots=slots).names == dtype.names[1:]


def test_a_named_axis_without_a_size_is_refused():
    with pytest.raises(KeyError, match="slots"):
        Vehicle.dtype()


def test_an_array_starts_with_the_first_values_nested_records_with_those_of_their_class():
    class Loaded(Lorry):
        corner: Float64[Array, "2"] = field(np.float64, 2, start=(1.0, 2.0))
        towed: Vehicle = field(Vehicle)

    made = Loaded.array((2, 3), slots=4)
    assert made.shape == (2, 3)
    assert np.all(made["corner"] == [1.0, 2.0])
    assert np.all(made["goal"] == -1)
    assert np.all(made["towed"]["met"] == 7)
    assert made["met"].shape == (2, 3, 4, 2)
    assert np.all(made["load"] == 2.5)
    assert np.all(made["pose"] == 0.0)
    assert not made["left"]["is_stuck"].any()


def test_numba_takes_no_numbers_for_those_that_another_record_begins_with():
    names = ["share"], ["share", "drift"], ["drift", "share"]
    for numbers in (one_record(dict.fromkeys(each, 0.5)) for each in names):
        double_share(numbers[0])  # a warning is an error here
        assert numbers["share"] == 1.0


@kernel
def double_share(numbers):
    add_share(numbers)


@kernel
def add_share(numbers):
    numbers.share += numbers.share


def test_a_restart_leaves_the_columns_that_others_have_added():
    made = np.zeros(
        2, record_dtype([("met", np.int64), ("speed", np.float64), ("is_stuck", np.bool_)])
    )
    made["met"], made["speed"] = 3, 4.0
    Wheel.restart(made)
    assert made["met"].tolist() == [3, 3]
    assert made["speed"].tolist() == [0.0, 0.0]
