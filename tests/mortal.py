"""A fleet in this process whose world may end at once, and go on from its checkpoint."""

from pathlib import Path
from typing import Any

from deploy.run.local import LocalFleet
from protocol.bus.bus import Bus
from protocol.scenario.model import Scenario
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
