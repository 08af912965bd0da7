"""How Chipmunk, the library below pymunk, lays out a space in memory.

From chipmunk_private.h and cpBBTree.c of Chipmunk 7 and of Munk2D, its successor in pymunk 7. What
nothing here reads is named all the same, for its size.
"""

import ctypes

POINTER, DOUBLE, UINT32 = ctypes.c_void_p, ctypes.c_double, ctypes.c_uint32


class Space(ctypes.Structure):
    """A space: its clock, its lists and its two trees."""

    _fields_ = (
        ("iterations", ctypes.c_int), ("gravity", DOUBLE * 2), ("damping", DOUBLE),
        ("thresholds_of_sleep", DOUBLE * 2), ("collision_slop", DOUBLE), ("collision_bias", DOUBLE),
        ("collision_persistence", UINT32), ("user_data", POINTER), ("stamp", UINT32),
        ("last_step", DOUBLE), ("bodies", POINTER * 4), ("n_shapes_ever", ctypes.c_size_t),
        ("walls", POINTER), ("robots", POINTER), ("constraints", POINTER), ("touching", POINTER),
    )  # fmt: skip


class Body(ctypes.Structure):
    """A body."""

    _fields_ = (
        ("functions", POINTER * 2), ("mass", DOUBLE * 2), ("moment", DOUBLE * 2),
        ("centre", DOUBLE * 2), ("position", DOUBLE * 2), ("velocity", DOUBLE * 2),
        ("force", DOUBLE * 2), ("angle", DOUBLE), ("spin", DOUBLE), ("torque", DOUBLE),
        ("transform", DOUBLE * 6), ("user_data", POINTER), ("push", DOUBLE * 3), ("space", POINTER),
    )  # fmt: skip


class Tree(ctypes.Structure):
    """A tree in which the shapes that may touch another are looked for."""

    _fields_ = (
        ("functions", POINTER * 2), ("tree_of_walls", POINTER), ("tree_of_robots", POINTER),
        ("velocity_of", POINTER), ("leaves", POINTER), ("root", POINTER), ("pools", POINTER * 3),
        ("stamp", UINT32),
    )  # fmt: skip


class Below(ctypes.Structure):
    """The end of a node without a shape."""

    _fields_ = (("first", POINTER), ("second", POINTER))


class Leaf(ctypes.Structure):
    """The end of a node with a shape."""

    _fields_ = (("stamp", UINT32), ("pairs", POINTER))


class Either(ctypes.Union):
    """What a node ends in."""

    _fields_ = (("below", Below), ("leaf", Leaf))


class Node(ctypes.Structure):
    """A node of a tree, with the box of all that is below it [m]."""

    _anonymous_ = ("either",)
    _fields_ = (
        ("shape", POINTER), ("box", DOUBLE * 4), ("parent", POINTER), ("either", Either),
    )  # fmt: skip


class Thread(ctypes.Structure):
    """The place of a pair in the list of one of its leaves."""

    _fields_ = (("previous", POINTER), ("leaf", POINTER), ("next", POINTER))


class Pair(ctypes.Structure):
    """Two leaves whose boxes overlap."""

    _fields_ = (("a", Thread), ("b", Thread), ("id", UINT32))
