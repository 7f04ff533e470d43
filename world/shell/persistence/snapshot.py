"""A snapshot: all that a world and its shell know at the end of a tick, as bytes.

It stands in the journal for all that led there, so that a run of days is neither kept nor done again from
its beginning. Nothing has to be written out for it: whatever a world is made of is pickled as it is. Read
are the project's own classes and plain values only; a file that names anything else is refused.
"""

from __future__ import annotations

import io
import pickle
import time
from collections.abc import Mapping
from hashlib import sha256
from types import MappingProxyType
from typing import Any

import msgspec

from protocol.messages import Count, Id
from world.judge import trajectory
from world.shell.processes import Processes
from world.shell.run import Run
from world.world import World

_OWN = ("protocol.", "world.")
_PLAIN = {
    "builtins": ("complex", "frozenset", "list", "set"),
    "collections": ("Counter", "defaultdict", "deque"),
    "numpy": ("dtype", "ndarray"),
    "numpy._core.multiarray": ("_reconstruct", "scalar"),
    "numpy._core.numeric": ("_frombuffer",),
}


class Snapshot(msgspec.Struct, frozen=True, array_like=True, tag="snapshot"):
    """A run between two ticks."""

    world: bytes
    sha256: bytes  # of the world: what it holds is not checked further
    began: float  # s, wall clock: when its first tick began
    processes: Processes
    expected: dict[Id, Count]  # for how many next lives of each robot the world has waited so far


def is_due(world: World) -> bool:
    """Whether a snapshot is to be taken of a world whose tick was just closed."""
    return world.tick % trajectory.LINK == 0 and not world.verdict


def take(run: Run, processes: Processes, expected: Mapping[int, int]) -> Snapshot:
    """Of a run whose tick was just closed."""
    began = time.time() - (time.monotonic() - run.began)
    state = frozen(run.world)
    return Snapshot(state, sha256(state).digest(), began, processes.copy(), dict(expected))


def restored(snapshot: Snapshot) -> World:
    """The world of a snapshot; raises `pickle.UnpicklingError` if it is not one."""
    if sha256(snapshot.world).digest() != snapshot.sha256:
        raise pickle.UnpicklingError("the snapshot is damaged")
    return thawed(snapshot.world)


def frozen(world: World) -> bytes:
    """All that follows from what a world was told; its news has to be handed out."""
    world.news()  # measures what was put aside
    note, world.coordinator.note = world.coordinator.note, None
    try:
        with io.BytesIO() as file:
            _Pickler(file, protocol=5).dump(world)
            return file.getvalue()
    finally:
        world.coordinator.note = note


def thawed(state: bytes) -> World:
    """A world that goes on as the one that was frozen.

    Raises:
        pickle.UnpicklingError: the bytes are not those of a world.
    """
    try:
        world = _Unpickler(io.BytesIO(state)).load()
    except Exception as error:
        raise pickle.UnpicklingError(f"no snapshot of this version: {error}") from error
    if not isinstance(world, World):
        raise pickle.UnpicklingError("no snapshot of a world")
    return world


class _Pickler(pickle.Pickler):
    def reducer_override(self, value: Any) -> Any:
        return (_view, (dict(value),)) if type(value) is MappingProxyType else NotImplemented


class _Unpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        module = module.replace("numpy.core.", "numpy._core.")  # so called before numpy 2
        found = super().find_class(module, name) if module.startswith(_OWN) and "." not in name else None
        is_own = isinstance(found, type) and found.__module__ == module
        if is_own or found is _view:
            return found
        if name in _PLAIN.get(module, ()):
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"it names {module}.{name}")


def _view(values: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(values)
