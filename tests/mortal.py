"""Fleets in this process whose world may end at once, and go on from its checkpoint."""

import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

from deploy.run.local import LocalFleet
from protocol.bus.bus import Bus, Publish
from protocol.keys import Stream
from protocol.scenario.model import Scenario
from tests.proxy import Proxy
from world.shell.checkpoint import Checkpoint
from world.shell.node import WorldNode


class MortalFleet(LocalFleet):
    """Its world keeps a checkpoint at `path`, which is created here; without one it does not return."""

    def __init__(self, scenario: Scenario, path: Path | None, **options: Any) -> None:
        self._path, self._checkpoint = path, None
        if path is not None:
            Checkpoint.create(path)
        super().__init__(scenario, **options)

    def _world(self, bus: Bus, checkpoint: Checkpoint | None = None) -> WorldNode:
        if self._path is not None:
            checkpoint = self._checkpoint = Checkpoint(self._path, self.run, self._scenario)
        return super()._world(bus, checkpoint)

    def kill_world(self) -> None:
        """End the world's node at once, with its token; only its checkpoint remains."""
        self.world_bus.close()
        if self._checkpoint is not None:
            self._checkpoint.close()


class Death(BaseException):
    """kill -9, at this very operation."""


class Doom:
    """Counts the operations by which any process can tell what a world did, and dies at some of them.

    A write of the checkpoint is three: before it, in the middle of it, after it; a publication is one.
    """

    def __init__(self, at: Iterable[int] = ()) -> None:
        self.at = set(at)
        self.count = itertools.count()
        self.deaths = 0

    @contextmanager
    def in_force(self) -> Iterator[None]:
        """Inside, writes of checkpoints are operations."""
        with patch.object(os, "pwrite", self.write):
            yield

    def pass_by(self) -> None:
        if next(self.count) in self.at:
            self.deaths += 1
            raise Death

    def write(self, file: int, content: bytes, place: int) -> int:
        self.pass_by()
        half = len(content) // 2
        _pwrite(file, content[:half], place)
        self.pass_by()
        written = _pwrite(file, content[half:], place + half)
        self.pass_by()
        return half + written


_pwrite = os.pwrite


class DoomedFleet(MortalFleet):
    """A world that dies by its doom, and has a successor at once."""

    def __init__(self, scenario: Scenario, checkpoint: Path, doom: Doom, **options: Any) -> None:
        self.doom = doom
        super().__init__(scenario, checkpoint, **options)

    def start_world(self) -> None:
        try:
            super().start_world()
            node = self.world
            self.world_bus.node = Proxy(
                node, handle=self._mortal(node.handle), on_timer=self._mortal(node.on_timer)
            )
        except Death:
            self.kill_world()
            self.start_world()

    def _world(self, bus: Bus, checkpoint: Checkpoint | None = None) -> WorldNode:
        def publisher(stream: Stream, key: str) -> Publish:
            publish = bus.publisher(stream, key)

            def doomed(payload: bytes) -> None:
                self.doom.pass_by()
                publish(payload)

            return doomed

        return super()._world(Proxy(bus, publisher=publisher), checkpoint)

    def _mortal(self, act: Callable[..., None]) -> Callable[..., None]:
        def live(*told: Any) -> None:
            try:
                act(*told)
            except Death:
                self.kill_world()
                self.start_world()

        return live
