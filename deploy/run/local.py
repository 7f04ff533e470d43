"""A run within this process: the same nodes as over zenoh, on the in-process bus.

Robots that receive equal replies to their join requests share one decoded scenario, which is immutable.
"""

from __future__ import annotations

import gc
import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Final

from agents.shell.node import RobotNode
from deploy.run.launcher import Launcher, OnClock
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
from protocol.scenario.model import FaultKind, Scenario
from world.shell.checkpoint import Checkpoint
from world.shell.node import WorldNode

_YOUNG: Final = 1_000_000  # objects, instead of 700: messages are many, and freed by reference counts


@contextmanager
def seldom_collecting() -> Iterator[None]:
    """Collect garbage rarely inside; of several threads, the first to enter restores the setting."""
    before = gc.get_threshold()
    if before[0] >= _YOUNG:
        yield
        return
    gc.set_threshold(_YOUNG, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


class LocalFleet:
    """World and robots of a run in one thread, with the interface of `deploy.run.fleet.Fleet`.

    Args:
        scenario: with k as a number.
        speed: simulated seconds per second in lock-step, 0 for no limit.
        watch: called with every Clock.
        network: bus of the nodes; a new one by default.
    """

    def __init__(
        self,
        scenario: Scenario,
        run: str = "local",
        *,
        lockstep: bool = True,
        speed: float = 0.0,
        watch: OnClock = lambda _: None,
        record: Path | None = None,
        network: LocalNetwork | None = None,
    ) -> None:
        self.network = LocalNetwork() if network is None else network
        self.run = run
        # Reading a scenario of 1000 robots takes 2 ms and 0.5 MB: too much for each robot.
        self._read = lru_cache(maxsize=1)(decode_reply)
        self._scenario, self._lockstep, self._speed = scenario, lockstep, speed
        self._watch, self._record = watch, record
        self.report: dict[str, Any] = {}  # of the world, once the run has ended
        self.start_world()
        self._recorder = None if record is None else self._hear(record)
        self.robots: dict[int, LocalBus] = {}
        self._paused: dict[int, Node] = {}
        for robot in sorted(scenario.ids, key=self.turn):
            self.start(robot)
        self.launcher = Launcher(scenario, self, self.turn)
        clock = self.network.connect()
        clock.subscribe(world_key(run, "clock"))
        clock.node = self

    def start_world(self) -> None:
        """Start the world's node."""
        self.world_bus = self.network.connect()
        self.world = self.world_bus.node = self._world(self.world_bus)

    def _world(self, bus: Bus, checkpoint: Checkpoint | None = None) -> WorldNode:
        return WorldNode(
            bus,
            self.run,
            self._scenario,
            self._lockstep,
            speed=self._speed,
            warn=LOG.info,
            info=LOG.info,
            checkpoint=checkpoint,
            clock=time.monotonic,  # looked up now: tests that skip waits replace it
            on_report=self.report.update,
        )

    def turn(self, robot: int) -> Any:
        """Sort key of the order in which robots join."""
        return robot

    def start(self, robot: int) -> Node:
        bus = self.robots[robot] = self.network.connect()
        warn = partial(_warn, robot)
        node: Node = RobotNode(bus, self.run, robot, warn=warn, read=self._read)
        bus.node = node
        return node

    # -- a Node, which receives the world's Clock

    finished, deadline = False, float("inf")

    def handle(self, event: Event) -> None:
        if not isinstance(event, Sample) or not isinstance(clock := decode(event.key, event.payload), Clock):
            return
        self.launcher.follow(clock)
        for robot, bus in self.robots.items():  # the process of a removed robot ends
            if isinstance(bus.node, RobotNode) and bus.node.verdict == "removed":
                self.kill(robot)
                self.launcher.removed(robot)
        self._watch(clock)

    def on_timer(self, now: float) -> None:
        """No timers."""

    # -- RobotProcesses

    def knows(self, robot: int) -> bool:
        return robot in self.robots

    def runs(self, robot: int) -> bool:
        bus = self.robots.get(robot)
        return bus is not None and bus.node is not None

    def act(self, robot: int, event: FaultKind) -> None:
        getattr(self, event)(robot)

    def kill(self, robot: int) -> None:
        """End a robot's node at once, with its token."""
        self._paused.pop(robot, None)
        self.robots[robot].close()

    def pause(self, robot: int) -> None:
        """Stop delivering messages to a robot's node."""
        bus = self.robots[robot]
        if isinstance(bus.node, RobotNode):
            self._paused[robot] = bus.node
            bus.node = None

    def resume(self, robot: int) -> None:
        """Deliver messages to a paused node again."""
        if robot in self._paused:
            bus = self.robots[robot]
            bus.node = self._paused.pop(robot)
            self.network.notify(bus)

    def restart(self, robot: int) -> None:
        self.kill(robot)
        self.start(robot)

    def welcome(self, robot: int) -> bool:
        if robot in self._paused:
            self.kill(robot)  # the next node can join once the world has seen the end of this token
            return False
        self.start(robot).on_timer(time.monotonic())
        return True

    def __enter__(self) -> LocalFleet:
        return self

    def __exit__(self, *details: object) -> None:
        if self._recorder is not None:
            self._recorder.finish()

    def recordings(self) -> list[str]:
        """Files of the recording."""
        return [] if self._record is None else [str(self._record)]

    def record(self, result: Mapping[str, Any]) -> None:
        """Finish the recording, if there is one, with the complete result."""
        if self._recorder is not None:
            self._recorder.finish(json.dumps(result))

    def processes(self) -> list[dict[str, Any]]:
        """No rows: a local fleet has no processes of its own."""
        return []

    def _hear(self, record: Path) -> Recorder:
        bus = self.network.connect()
        bus.subscribe(everything(self.run))
        recorder = bus.node = Recorder(bus, self.run, RecordingWriter(record, self.run, self._scenario))
        return recorder

    def execute(self) -> dict[str, Any]:
        """Run to the end, and return the report. A signal ends the run as interrupted, with its report."""
        self._run(lambda: self._is_over or self.world.world.tick > 0)  # until all have joined
        with seldom_collecting():
            self._run(lambda: self._is_over)
        if not self.world.finished:
            self.world.interrupt("interrupted", INTERRUPTED)
        if self._recorder is not None:
            self._recorder.close()
        return self.report

    def _run(self, finished: Callable[[], bool]) -> None:
        """Run the network; raises JoinError if a robot is refused before the start. Later, it ends alone."""
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
        """Run until the open tick is over; False once there is a verdict."""
        world = self.world.world
        tick = world.tick
        self._run(lambda: world.tick > tick or bool(world.verdict) or STOP.requested)
        return not world.verdict


def _warn(robot: int, text: str) -> None:
    LOG.warning(f"robot-{robot}: {text}")
