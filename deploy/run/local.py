"""A whole run in this process: the same nodes as on zenoh, on the in-process bus.

Robots whose requests to join are answered by the same bytes share what these say. Equal bytes say the same,
and nothing can change a scenario, which is frozen throughout: no robot can tell whether others share it.
"""

from __future__ import annotations

import gc
import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache, partial
from pathlib import Path
from threading import Lock
from typing import Any, Final

from agents.shell.node import RobotNode
from deploy.run.launcher import Launcher
from deploy.run.result import INTERRUPTED
from deploy.telemetry.recording.recorder import Recorder
from deploy.telemetry.recording.writer import RecordingWriter
from protocol.bus.bus import Bus, Event, Node, Sample
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.codec import decode
from protocol.errors import JoinError
from protocol.joining import decode_reply
from protocol.keys import everything, world_key
from protocol.messages import Clock
from protocol.process.log import LOG
from protocol.process.signals import STOP
from protocol.scenario.model import Event as ProcessEvent
from protocol.scenario.model import Scenario
from world.shell.checkpoint import Checkpoint
from world.shell.node import WorldNode

_YOUNG: Final = 1_000_000  # objects, instead of 700: messages of a tick are many, and are gone by themselves
_GROWTH: Final = 1.25  # of all objects until they are looked through: what Python's own collector waits for


@contextmanager
def seldom_collecting() -> Iterator[None]:
    """Inside, what is there already is not looked at, and what comes seldom: of 1000 robots that is a quarter
    of a tick. Threads may be inside together: what was before is back when the last has left."""
    _ASIDE.enter()
    try:
        yield
    finally:
        _ASIDE.leave()


class _Aside:
    """What is there before a run. Looking through all of it takes as long as a short run, where much has been
    imported: only what is young is, until there is a quarter more than all that was left last time."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._inside = 0
        self._before = gc.get_threshold()
        self._left = 0

    def enter(self) -> None:
        with self._lock:
            if not self._inside:
                self._before = gc.get_threshold()
                self._put()
                gc.set_threshold(_YOUNG, *self._before[1:])
            self._inside += 1

    def leave(self) -> None:
        with self._lock:
            self._inside -= 1
            if not self._inside:
                gc.set_threshold(*self._before)
                gc.unfreeze()

    def _put(self) -> None:
        gc.collect(1)
        gc.freeze()
        if gc.get_freeze_count() > _GROWTH * self._left:
            gc.unfreeze()
            gc.collect()
            gc.freeze()
            self._left = gc.get_freeze_count()


_ASIDE: Final = _Aside()


Watcher = Callable[[Clock], None]


class LocalFleet:
    """World and robots of a run in one thread: `deploy.run.fleet.Fleet` in small.

    Args:
        scenario: k already a number.
        run: name of the run.
        lockstep: whether the world waits for every robot.
        speed: simulated seconds per second that lock-step is held to, 0 for no limit.
        watch: is told every Clock.
        record: file to record to.
        checkpoint: file (see `Checkpoint.create`) with which another world may follow on one that dies.
        network: where its nodes meet; one of its own unless given.

    Attributes:
        report: of the world, once the run has ended.
    """

    def __init__(
        self,
        scenario: Scenario,
        run: str = "local",
        *,
        lockstep: bool = True,
        speed: float = 0.0,
        watch: Watcher | None = None,
        record: Path | None = None,
        checkpoint: Path | None = None,
        network: LocalNetwork | None = None,
    ) -> None:
        self.network = LocalNetwork() if network is None else network
        self.run = run
        # To read a scenario of 1000 robots takes 2 ms, and half a megabyte: 2 s and 0.5 GB if each did.
        self._read = lru_cache(maxsize=1)(decode_reply)
        self._scenario, self._lockstep, self._speed = scenario, lockstep, speed
        self._path, self._watch = checkpoint, watch
        self.report: dict[str, Any] = {}
        self.start_world()
        self._writer = None if record is None else RecordingWriter(record)
        self._recorder = None if self._writer is None else self._hear(self._writer)
        self.robots: dict[int, LocalBus] = {}
        self._paused: dict[int, Node] = {}
        for robot in sorted(scenario.ids, key=self.turn):
            self.start(robot)
        self.launcher = Launcher(scenario, self, self.turn)
        clock = self.network.connect()
        clock.subscribe(world_key(run, "clock"))
        clock.node = _Follower(self._follow)

    def start_world(self) -> None:
        """Start the world's node, where the checkpoint says that the one before it was."""
        self._checkpoint: Checkpoint | None = None
        if self._path is not None:
            self._checkpoint = Checkpoint(self._path, self.run, self._scenario)
        self.world_bus = self.network.connect()
        self.world = self.world_bus.node = self._world(self.world_bus)

    def _world(self, bus: Bus) -> WorldNode:
        return WorldNode(
            bus,
            self.run,
            self._scenario,
            self._lockstep,
            speed=self._speed,
            say=LOG.info,
            note=LOG.info,
            checkpoint=self._checkpoint,
            clock=time.monotonic,  # the one in force: tests that skip waits replace it
            tell=self.report.update,
        )

    def kill_world(self) -> None:
        """End the world's node at once; its token goes, and nothing is left of it but its checkpoint."""
        self.world_bus.close()
        if self._checkpoint is not None:
            self._checkpoint.close()

    def turn(self, robot: int) -> Any:
        """When a robot joins, of several that may: those with less first."""
        return robot

    def start(self, robot: int) -> Node:
        """Start a robot's node."""
        bus = self.robots[robot] = self.network.connect()
        say = partial(_warn, robot)
        node: Node = RobotNode(bus, self.run, robot, say=say, read=self._read)
        bus.node = node
        return node

    # -- what the launcher asks for

    def _follow(self, clock: Clock) -> None:
        self.launcher.follow(clock)
        for robot, bus in self.robots.items():  # a process ends once it knows that its robot was removed
            if isinstance(bus.node, RobotNode) and bus.node.verdict == "removed":
                self.kill(robot)
                self.launcher.removed(robot)
        if self._watch is not None:
            self._watch(clock)

    def knows(self, robot: int) -> bool:
        """As `Processes`."""
        return robot in self.robots

    def runs(self, robot: int) -> bool:
        """As `Processes`."""
        bus = self.robots.get(robot)
        return bus is not None and bus.node is not None

    def act(self, robot: int, event: ProcessEvent) -> None:
        """As `Processes`."""
        getattr(self, event)(robot)

    def kill(self, robot: int) -> None:
        """End a robot's node at once; its token goes."""
        self._paused.pop(robot, None)
        self.robots[robot].close()

    def pause(self, robot: int) -> None:
        """Have a robot's node take nothing in."""
        bus = self.robots[robot]
        if isinstance(bus.node, RobotNode):
            self._paused[robot] = bus.node
            bus.node = None

    def resume(self, robot: int) -> None:
        """Let a robot's node go on, if it is paused."""
        if robot in self._paused:
            bus = self.robots[robot]
            bus.node = self._paused.pop(robot)
            self.network.notify(bus)

    def restart(self, robot: int) -> None:
        """End a robot's node, and start another."""
        self.kill(robot)
        self.start(robot)

    def welcome(self, robot: int) -> bool:
        """As `Processes`."""
        if robot in self._paused:
            self.kill(robot)  # its token goes; when that is known, the next one can come
            return False
        self.start(robot).wake(time.monotonic())
        return True

    def __enter__(self) -> LocalFleet:
        return self

    def __exit__(self, *details: object) -> None:
        self._finish(None)

    def recordings(self) -> list[str]:
        """The files of the recording."""
        return [] if self._writer is None else [str(self._writer.path)]

    def record(self, result: Mapping[str, Any]) -> None:
        """Finish the recording, if there is one, with the complete result of the run."""
        self._finish(json.dumps(result))

    def _finish(self, result: str | None) -> None:
        writer, self._writer = self._writer, None
        if writer is not None and self._recorder is not None:
            writer.finish(result or self._recorder.result)

    def processes(self) -> list[dict[str, Any]]:
        """There are none of its own."""
        return []

    def _hear(self, writer: RecordingWriter) -> Recorder:
        bus = self.network.connect()
        bus.subscribe(everything(self.run))
        recorder = bus.node = Recorder(bus, self.run, writer)
        return recorder

    def execute(self) -> dict[str, Any]:
        """Run to the end; the report. A signal ends the run as interrupted, with its report."""
        self._run(lambda: self._is_over or self.world.world.tick > 0)  # all are there
        with seldom_collecting():
            self._run(lambda: self._is_over)
        if not self.world.finished:
            self.world.interrupt("interrupted", INTERRUPTED)
        if self._recorder is not None:
            self._recorder.close()
        return self.report

    def _run(self, finished: Callable[[], bool]) -> None:
        """Run the network; a robot that is turned away once the run has begun ends alone, as a process would.

        Raises:
            JoinError: a robot is turned away before.
        """
        while not finished():
            try:
                self.network.run(finished)
            except JoinError as refusal:
                if not self.world.world.tick:
                    raise
                _warn(refusal.robot, str(refusal))
                self.kill(refusal.robot)

    @property
    def _is_over(self) -> bool:
        return self.world.finished or STOP.requested

    def step(self) -> bool:
        """Run until the open tick is over, and say whether another follows: False once there is a verdict."""
        world = self.world.world
        tick = world.tick
        self._run(lambda: world.tick > tick or bool(world.verdict) or STOP.requested)
        return not world.verdict


class _Follower:
    """A node that hears the world's Clock."""

    finished, deadline = False, float("inf")

    def __init__(self, follow: Callable[[Clock], None]) -> None:
        self._follow = follow

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample) and isinstance(message := decode(event.key, event.payload), Clock):
            self._follow(message)

    def wake(self, now: float) -> None:
        """Nothing is due by the wall clock."""


def _warn(robot: int, text: str) -> None:
    """What a robot's process would say on standard error."""
    LOG.warning(f"robot-{robot}: {text}")
