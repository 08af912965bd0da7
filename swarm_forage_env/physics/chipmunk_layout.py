"""How Chipmunk, the library below pymunk, lays out a space in memory.

From chipmunk_private.h and cpBBTree.c of Chipmunk 7 and of Munk2D, its successor in pymunk 7. What
nothing here reads is named all the same, for its size.
"""

import ctypes


class Space(ctypes.Structure):
    """A space: its clock, its lists and its two trees."""

    _fields_ = (
        ("iterations", ctypes.c_int),
        ("gravity", ctypes.c_double * 2),
        ("damping", ctypes.c_double),
        ("thresholds_of_sleep", ctypes.c_double * 2),
        ("collision_slop", ctypes.c_double),
        ("collision_bias", ctypes.c_double),
        ("collision_persistence", ctypes.c_uint32),
        ("user_data", ctypes.c_void_p),
        ("stamp", ctypes.c_uint32),
        ("last_step", ctypes.c_double),
        ("bodies", ctypes.c_void_p * 4),
        ("n_shapes_ever", ctypes.c_size_t),
        ("walls", ctypes.c_void_p),
        ("robots", ctypes.c_void_p),
        ("constraints", ctypes.c_void_p),
        ("touching", ctypes.c_void_p),
    )


class Body(ctypes.Structure):
    """A body."""

    _fields_ = (
        ("functions", ctypes.c_void_p * 2),
        ("mass", ctypes.c_double * 2),
        ("moment", ctypes.c_double * 2),
        ("centre", ctypes.c_double * 2),
        ("position", ctypes.c_double * 2),
        ("velocity", ctypes.c_double * 2),
        ("force", ctypes.c_double * 2),
        ("angle", ctypes.c_double),
        ("spin", ctypes.c_double),
        ("torque", ctypes.c_double),
        ("transform", ctypes.c_double * 6),
        ("user_data", ctypes.c_void_p),
        ("push", ctypes.c_double * 3),
        ("space", ctypes.c_void_p),
    )


class Tree(ctypes.Structure):
    """A tree in which the shapes that may touch another are looked for."""

    _fields_ = (
        ("functions", ctypes.c_void_p * 2),
        ("tree_of_walls", ctypes.c_void_p),
        ("tree_of_robots", ctypes.c_void_p),
        ("velocity_of", ctypes.c_void_p),
        ("leaves", ctypes.c_void_p),
        ("root", ctypes.c_void_p),
        ("pools", ctypes.c_void_p * 3),
        ("stamp", ctypes.c_uint32),
    )


class Below(ctypes.Structure):
    """The end of a node without a shape."""

    _fields_ = (("first", ctypes.c_void_p), ("second", ctypes.c_void_p))


class Leaf(ctypes.Structure):
    """The end of a node with a shape."""

    _fields_ = (("stamp", ctypes.c_uint32), ("pairs", ctypes.c_void_p))


class Either(ctypes.Union):
    """What a node ends in."""

    _fields_ = (("below", Below), ("leaf", Leaf))


class Node(ctypes.Structure):
    """A node of a tree, with the box of all that is below it [m]."""

    _anonymous_ = ("either",)
    _fields_ = (
        ("shape", ctypes.c_void_p),
        ("box", ctypes.c_double * 4),
        ("parent", ctypes.c_void_p),
        ("either", Either),
    )


class Thread(ctypes.Structure):
    """The place of a pair in the list of one of its leaves."""

    _fields_ = (("previous", ctypes.c_void_p), ("leaf", ctypes.c_void_p), ("next", ctypes.c_void_p))


class Pair(ctypes.Structure):
    """Two leaves whose boxes overlap."""

    _fields_ = (("a", Thread), ("b", Thread), ("id", ctypes.c_uint32))
