"""Snapshot of the contact state of a pymunk space.

pymunk's own copy of a space loses the order in which contacts are solved, which follows from the
tree in which Chipmunk finds bodies that may touch. pymunk has no function for this tree, so it is
read from and written to memory directly: `chipmunk_layout` declares the layout, `_trees` checks it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pymunk
from pymunk._chipmunk import ffi, lib

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.physics.chipmunk_layout import LAYOUT
from swarm_forage_env.physics.pymunk_buffers import address_of

INNER = -1
"""Index of an inner node of the tree: it has two children and no shape."""

FIRST_TOUCH, TOUCHING = 0, 1
"""States of a contact; FIRST_TOUCH becomes TOUCHING at the start of the next step."""


@dataclass(frozen=True)
class ContactMemory:
    """State on which the next step of a space depends, except poses and velocities of bodies.

    Shapes are identified by index: first those of the robots, then the walls.
    """

    stamps: tuple[int, int]
    """Step counters of the space and of its tree."""
    last_step: float
    """Length of the last step [s]."""
    pushes: Float64[Array, "bodies 3"]
    """Velocities that the next step adds to each body to remove overlaps [m/s, m/s, rad/s]."""
    order: tuple[int, ...]
    """Nodes of the tree in depth-first order: index of the shape of a leaf, INNER elsewhere."""
    boxes: Float64[Array, "nodes 4"]
    """Bounding box of each node [m]."""
    pairs: tuple[tuple[int, int, int], ...]
    """Pairs of leaves with overlapping boxes: indices of the two shapes, and Chipmunk's id."""
    lists: tuple[tuple[int, ...], ...]
    """Indices of the pairs of each shape, in Chipmunk's order."""
    contacts: tuple[tuple[int, int, int, int, bytes], ...]
    """Contacts: two shapes, step of the last touch, state, and contact points with impulses."""


def remembered(space: pymunk.Space) -> ContactMemory:
    """Return the contact state of a space, which stays unchanged."""
    tree, walls = _trees(space)
    nodes, leaves = list(_walk(tree.root)), _leaves(space, tree, walls)
    number = {shape: k for k, shape in enumerate(_shapes(space))}
    places: dict[Any, int] = {}
    lists = [[places.setdefault(pair, len(places)) for pair in _pairs_of(each)] for each in leaves]
    return ContactMemory(
        (lib.cpSpaceGetTimestamp(space._space), tree.stamp),
        lib.cpSpaceGetCurrentTimeStep(space._space),
        np.array([list(body.push) for body in _bodies(space)]),
        tuple(number.get(node.shape, INNER) for node in nodes),
        np.array([list(node.box) for node in nodes]),
        tuple((number[p.a.leaf.shape], number[p.b.leaf.shape], p.id) for p in places),
        tuple(map(tuple, lists)),
        tuple(_contact(arbiter, number) for arbiter in space._get_arbiters()),
    )


def recall(space: pymunk.Space, memory: ContactMemory) -> None:
    """Write a contact state to a new space with the same shapes."""
    tree, walls = _trees(space)
    leaves = _leaves(space, tree, walls)
    for body, push in zip(_bodies(space), memory.pushes.tolist(), strict=True):
        body.push = push
    _grow(tree, memory, leaves)
    pairs = _link(memory, leaves)
    stamp, tree.stamp = memory.stamps
    lib.cpSpaceSetTimestamp(space._space, stamp)
    lib.cpSpaceSetCurrentTimeStep(space._space, memory.last_step)
    contacts = [_add_contact(space, *each) for each in memory.contacts]
    # the calls also listed contacts that had ended as touching: clear the list
    _at("Space", space._space).n_touching[0] = 0
    # Chipmunk reads both again when `_space` is freed: an older attribute, freed before this one
    space._recalled = pairs, contacts  # type: ignore[attr-defined]


def _at(kind: str, pointer: object) -> Any:  # noqa: ANN401 of this kind
    """Cast a pointer of pymunk to a type of LAYOUT."""
    return LAYOUT.cast(f"{kind} *", address_of(pointer))


def _trees(space: pymunk.Space) -> tuple[Any, Any]:
    """Return the trees of robots and walls; ConfigError if the memory layout is unknown."""
    at = _at("Space", space._space)
    there = at.collision_slop, at.stamp, at.last_step, at.n_shapes_ever
    expected = (
        space.collision_slop,
        lib.cpSpaceGetTimestamp(space._space),
        lib.cpSpaceGetCurrentTimeStep(space._space),
        lib.cpSpaceGetShapeIDCounter(space._space),
    )
    is_known = there == expected and {body.space for body in _bodies(space)} == {at}
    if is_known and (at.robots.tree_of_walls, at.walls.tree_of_robots) == (at.walls, at.robots):
        return at.robots, at.walls
    raise ConfigError(
        f"physics='rigid': pymunk {pymunk.version} stores its contacts in an unknown layout, so"
        " that they can be neither copied nor restored; use pymunk 7.3 or physics='kinematic'"
    )


def _bodies(space: pymunk.Space) -> list[Any]:
    return [_at("Body", body._body) for body in space.bodies]


def _shapes(space: pymunk.Space) -> list[Any]:
    return [_at("void", shape._shape) for shape in space.shapes]


def _leaves(space: pymunk.Space, *trees: Any) -> list[Any]:  # noqa: ANN401 as laid out
    leaf_of = {node.shape: node for tree in trees for node in _walk(tree.root)}
    return [leaf_of[shape] for shape in _shapes(space)]


def _walk(root: Any) -> Iterator[Any]:  # noqa: ANN401 as laid out
    ahead = [root]
    while ahead:
        node = ahead.pop()
        yield node
        if not node.shape:
            ahead += [node.second, node.first]


def _pairs_of(leaf: Any) -> Iterator[Any]:  # noqa: ANN401 as laid out
    pair = leaf.pairs
    while pair:
        yield pair
        pair = _thread_of(pair, leaf).next


def _thread_of(pair: Any, leaf: Any) -> Any:  # noqa: ANN401 as laid out
    return pair.a if pair.a.leaf == leaf else pair.b


def _grow(tree: Any, memory: ContactMemory, leaves: list[Any]) -> None:  # noqa: ANN401 as laid out
    """Rebuild the remembered tree and its boxes from the nodes of a tree."""
    spare = [node for node in _walk(tree.root) if not node.shape]
    parents: list[Any] = []
    for number, box in zip(memory.order, memory.boxes.tolist(), strict=True):
        node = spare.pop() if number == INNER else leaves[number]
        node.box = box
        if not parents:
            tree.root, node.parent = node, LAYOUT.NULL
        else:
            parent = node.parent = parents[-1]
            if not parent.first:
                parent.first = node
            else:
                parent.second = node
                parents.pop()
        if number == INNER:
            node.first = LAYOUT.NULL
            parents.append(node)


def _link(memory: ContactMemory, leaves: list[Any]) -> object:
    """Link the pairs to their leaves; returns the memory of the pairs."""
    pairs = LAYOUT.new("Pair[]", len(memory.pairs))
    for pair, (a, b, number) in zip(pairs, memory.pairs, strict=True):
        pair.a.leaf, pair.b.leaf, pair.id = leaves[a], leaves[b], number
    for leaf, own in zip(leaves, memory.lists, strict=True):
        at = [pairs + k for k in own]
        leaf.pairs = at[0] if at else LAYOUT.NULL
        nothing = [LAYOUT.NULL]
        for pair, before, after in zip(at, nothing + at, at[1:] + nothing, strict=False):
            thread = _thread_of(pair, leaf)
            thread.previous, thread.next = before, after
    return pairs


def _contact(arbiter: Any, number: dict[Any, int]) -> tuple[int, int, int, int, bytes]:  # noqa: ANN401 pymunk's
    a, b = (number[_at("void", shape)] for shape in (arbiter.a, arbiter.b))
    state = TOUCHING if arbiter.state == FIRST_TOUCH else arbiter.state
    size = arbiter.count * ffi.sizeof("struct cpContact")
    points = bytes(ffi.buffer(arbiter.contacts, size)) if size else b""
    return a, b, arbiter.stamp, state, points


def _add_contact(
    space: pymunk.Space, a: int, b: int, stamp: int, state: int, points: bytes
) -> object:
    """Add a contact to a space; returns the memory of the contact."""
    shapes = list(space.shapes)
    arbiter = ffi.new("struct cpArbiter *")
    count = len(points) // ffi.sizeof("struct cpContact")
    arbiter.contacts = lib.cpContactArrAlloc(count)
    ffi.buffer(arbiter.contacts, len(points))[:] = points
    arbiter.a, arbiter.b = shapes[a]._shape, shapes[b]._shape
    arbiter.body_a, arbiter.body_b = _body_of(shapes[a]), _body_of(shapes[b])
    arbiter.count = count
    arbiter.stamp, arbiter.state, arbiter.processCollision = stamp, state, True
    lib.cpSpaceAddCachedArbiter(space._space, arbiter)
    return arbiter


def _body_of(shape: pymunk.Shape) -> object:
    assert shape.body is not None
    return shape.body._body
