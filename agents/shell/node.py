"""A robot as a participant: joins a run, and binds a `Robot` to a bus.

Lock-step: the node publishes the State when the Tick arrives, the Command when all awaited States have
arrived. When the world repeats a Tick, the node publishes both again, or in place of the Command the list of
missing States. Real time: it publishes both at once. When a run ends, or the world has fenced this life, the
node joins again: as a new life, or to receive the verdict. A robot with an external base shows its token once
it knows its place.
"""

from __future__ import annotations

import time
from collections import Counter
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from agents.bases.base import topics_of
from agents.peers.far import SummaryPlaces, read_summary
from agents.robot import Robot
from agents.shell.attached_base import AttachedBase
from agents.shell.ros_link import RosLink
from agents.shell.subscriptions import Subscriptions
from agents.shell.world_session import PATIENCE, RETRY, Emit, Read, WorldSession
from protocol import joining
from protocol.bus.bus import Bus, Event, Presence, RawSample, Sample
from protocol.codec import SHOWN, decode, encode
from protocol.errors import BusError, KeyGrammarError, MessageError
from protocol.keys import STREAMS, is_driver, parse, robot_key, robot_token, world_key, world_tokens
from protocol.messages import AnyMessage, Health, State, Tick, Wish

if TYPE_CHECKING:
    from agents.shell.ros_tools import RosTools

REPORT_PERIOD: Final = 0.5  # s between health messages


class RobotNode:
    """One robot id, one life after another, on one bus.

    Args:
        bus: a connection of its own.
        wait, read: as of `WorldSession`.
        namespace: as of `topics_of`.

    Raises:
        JoinError: the world refuses this id.
        BusError: the world is lost, or was never present, or is one of another run.
    """

    def __init__(
        self,
        bus: Bus,
        run: str,
        robot: int,
        *,
        wait: float = PATIENCE,
        namespace: str | None = None,
        warn: Emit = lambda _: None,
        info: Emit = lambda _: None,
        read: Read = joining.decode_reply,
    ) -> None:
        self.finished = False
        self.verdict = ""
        self.core: Robot | None = None
        self._bus, self._run, self._robot = bus, run, robot
        self._warn, self._info = warn, info
        self._namespace = namespace
        self._world = WorldSession(bus, run, robot, wait, warn, read)
        self._peers = Subscriptions(bus, run, robot)
        self._summary = world_key(run, "summary")
        self._link: RosLink | None = None
        self._base: AttachedBase | None = None
        self._tools: RosTools | None = None
        self._founded = False  # whether the run had begun when this robot was admitted
        self._announced = False
        self._noted = 0  # reported troubles of the robot
        self._ended = self._over = False  # this life; the run
        self._rejected: Counter[str] = Counter()
        self._newest_state = self._newest_command = b""  # payloads
        self._published = self._received = 0
        self._due = time.monotonic()
        bus.watch(world_tokens(run))  # before the first request: the world that admits it may die at once

    @property
    def deadline(self) -> float:
        """Time of the next `on_timer`, s, monotonic."""
        return self._due if self._base is None else min(self._due, self._base.due)

    # -- joining

    def _join(self) -> None:
        core = self.core
        begun = self._founded or (core is not None and core.tick >= 0)  # by all that this process knows
        try:
            health = self._health() if self._ended else None
            reply = self._world.ask(health, begun=begun)
        except BusError:
            if not self._over:
                raise
            self.finished = True  # the world left first
            return
        now = time.monotonic()
        if reply is None:
            self._due = now + RETRY
        elif isinstance(reply, joining.Wait):
            self._due = now + min(reply.after, PATIENCE)
        elif isinstance(reply, joining.Finished):
            self.verdict, self.finished = reply.verdict, True
            self._info(f"the run is over: {reply.verdict}")
        elif isinstance(reply, joining.Admission):
            life = reply.epoch, reply.incarnation
            if core is None or self._ended or life != (core.epoch, core.incarnation):
                self._begin(reply)
            self._world.back = False

    def _begin(self, admission: joining.Admission) -> None:
        if self._base is not None and self.core is not None:
            self._base.stand(self.core, founded=self._founded)  # under another epoch
        is_first = self.core is None
        self.core = Robot(
            admission.scenario,
            self._robot,
            admission.incarnation,
            lockstep=admission.lockstep,
            epoch=admission.epoch,
        )
        self._founded = admission.founded
        self._ended = self._over = False
        self._noted = 0
        self._info(f"life {admission.incarnation} begins, in scenario {admission.scenario.name!r}")
        self._due = time.monotonic() + REPORT_PERIOD
        self._world.admitted(admission)
        self._peers.begin(admission)
        if is_first:
            self._declare(self.core)

    def _declare(self, core: Robot) -> None:
        """Declare subscriptions before publishers before the token, which shows that all are there."""
        bus, run, robot = self._bus, self._run, self._robot
        bus.subscribe(robot_key(run, robot, "tick"))
        bus.subscribe(self._summary)
        if core.scenario.control.law == "external":
            bus.subscribe(robot_key(run, robot, "wish"))
        self._publish_state = bus.publisher(STREAMS["state"], robot_key(run, robot, "state"))
        self._publish_command = bus.publisher(STREAMS["command"], robot_key(run, robot, "command"))
        self._publish_health = bus.publisher(STREAMS["health"], robot_key(run, robot, "health"))
        self._declare_topics(core)
        if self._base is None:
            self._announce()

    def _declare_topics(self, core: Robot) -> None:
        table = topics_of(core.scenario, self._robot, self._namespace)
        if table is None:
            return
        from agents.bases.ros2 import Ros2Base  # imported only for robots with ROS topics
        from agents.shell.ros_tools import RosTools

        link = self._link = RosLink(self._bus, table)
        if core.scenario.is_external:
            self._base = AttachedBase(Ros2Base(core.scenario, self._robot, table), link, self._warn)
        if table.tools:
            operations = world_key(self._run, "operation")
            self._tools = RosTools(table, self._robot, link, self._bus, operations, self._warn)

    def _announce(self) -> None:
        self._bus.announce(robot_token(self._run, self._robot, self._world.session))
        self._announced = True

    # -- events

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample):
            self._on_sample(event.key, event.payload)
        elif isinstance(event, Presence):
            self._on_presence(event)
        elif isinstance(event, RawSample) and self._link is not None:
            try:
                self._on_foreign(self._link, event)
            except MessageError as error:
                self._reject(event.key, error)

    def _on_presence(self, event: Presence) -> None:
        """The token of a world, or of another process that drives the same base, appeared or disappeared."""
        if is_driver(event.key):
            if self._base is not None:
                self._base.on_driver(event.key, event.alive)
            return
        try:
            session = parse(event.key).session
        except KeyGrammarError:
            self._rejected["key"] += 1
            return
        alive, world = event.alive, self._world
        if not alive and self._over and world.is_own(session) and world.grace == 0.0:
            self.finished = True
            return
        world.on_token(session, alive)
        if world.back:
            self._due = time.monotonic()

    def _on_sample(self, key: str, payload: bytes) -> None:
        try:
            peer = self._peers.readers.get(key)
            heard = None if peer is None else peer.read(payload)
            message: AnyMessage | SummaryPlaces | None = None
            if peer is None:
                message = read_summary(key, payload) if key == self._summary else decode(key, payload)
        except MessageError as error:
            self._reject(key, error)
            return
        core = self.core
        if core is None or self._ended:
            return
        if heard is None:
            self._on_message(core, message)
        else:
            self._received += 1
            core.inbox.on_state(heard)
            self._command_if_complete(core)

    def _on_foreign(self, link: RosLink, event: RawSample) -> None:
        """Receive a ROS message, or the world's reply to an operation; raises MessageError."""
        base, tools, core = self._base, self._tools, self.core
        if tools is not None and tools.is_reply(event):
            return
        topic = link.topic_of(event)
        if base is not None and topic in base.topics:
            wish = base.on_message(topic, event.payload)
            if wish is not None and core is not None:
                core.on_wish(wish)
        elif tools is not None:
            tools.on_message(topic, event.payload)
            if tools.stopped and base is not None and core is not None:
                base.stand(core, founded=self._founded)

    def _on_message(self, core: Robot, message: AnyMessage | SummaryPlaces | None) -> None:
        """Receive any message other than the State of a known peer."""
        if isinstance(message, Tick | SummaryPlaces) and message.epoch != core.epoch:
            self._rejected["epoch"] += 1
            return
        if isinstance(message, State) and not core.scenario.hears_near:
            self._rejected["identity"] += 1  # of no active robot
            return
        self._received += 1
        if isinstance(message, Tick):
            self._on_tick(core, message)
        elif isinstance(message, SummaryPlaces):
            core.inbox.on_summary(message)
            self._command_if_complete(core)
        elif isinstance(message, Wish):
            core.on_wish(message.velocity)

    def _reject(self, key: str, error: MessageError) -> None:
        """Count a message that is dropped, and report the first for each reason."""
        self._rejected[error.reason] += 1
        if self._rejected[error.reason] == 1 and error.reason != "epoch":  # an earlier world's, no fault
            self._warn(f"dropped a message, {f'{key}: {error}'[:SHOWN]!r}")

    # -- ticks

    def _on_tick(self, core: Robot, tick: Tick) -> None:
        self._world.on_tick()
        if tick.over:
            self._over = True
            self._world.over()
            self._rejoin(core)
        elif core.has_ended(tick) or tick.incarnation > core.incarnation:
            self._rejoin(core)  # fenced, or replaced by another process
        elif tick.incarnation < core.incarnation:
            return  # of an earlier life
        elif tick.tick == core.tick:
            self._repeat(core, tick)
        elif tick.tick > core.tick:
            self._open(core, tick)

    def _open(self, core: Robot, tick: Tick) -> None:
        if tick.roster is not None and not core.scenario.hears_near:
            self._peers.subscribe([member.robot for member in tick.roster.members])
        if tick.grants is not None and core.scenario.hears_near:
            self._peers.attend({each.peer for each in tick.grants.bindings if each.peer > 0})
        sense = None if self._base is None else self._base.begin(core, tick)
        core.stopped = self._tools is not None and self._tools.stopped
        self._newest_state = encode(core.begin(tick, sense))
        if len(core.troubles) > self._noted:
            self._noted = len(core.troubles)
            self._warn(core.note)
        self._publish_state(self._newest_state)
        self._published += 1
        self._command_if_complete(core)

    def _command_if_complete(self, core: Robot) -> None:
        if core.inbox.is_open and core.inbox.complete:
            self._command(core)

    def _command(self, core: Robot) -> None:
        command = core.command()
        if self._base is not None:
            self._base.obey(command)
        self._newest_command = encode(command)
        self._publish_command(self._newest_command)
        if self._tools is not None:
            self._tools.publish(core, command, 0.0 if self._base is None else self._base.heading)
        self._published += 1
        self._peers.apply(core.tick)

    def _repeat(self, core: Robot, tick: Tick) -> None:
        """Answer a repeated Tick, as the State may be lost; without a Command name the missing States."""
        self._publish_state(self._newest_state)
        if not core.inbox.is_open:
            self._publish_command(self._newest_command)
        core.inbox.reconsider(tick)
        self._command_if_complete(core)
        if core.inbox.is_open and core.inbox.missing:
            self._publish_command(encode(core.complaint()))

    def _rejoin(self, core: Robot) -> None:
        self._ended = True
        self._report()
        self._due = time.monotonic()
        if self._base is not None:
            self._base.stand(core, founded=self._founded)

    # -- time

    def on_timer(self, now: float) -> None:
        base = self._base
        if base is not None and self.core is not None and now >= base.due:
            base.on_timer(self.core, founded=self._founded)
            if base.in_place and not self._announced:
                self._announce()
        if now >= self._due:
            self._look(now)

    def _look(self, now: float) -> None:
        if self.core is None or self._ended or self._world.back:
            self._join()
            return
        self._due = now + REPORT_PERIOD
        self._report()
        if self._world.check(now):
            self._join()

    def _report(self) -> None:
        self._publish_health(encode(self._health()))

    def _health(self) -> Health:
        core = self.core
        assert core is not None
        health = core.health(self._published, self._received, dict(self._rejected))
        trouble = "" if self._base is None else self._base.trouble
        return replace(health, note=trouble) if trouble else health
