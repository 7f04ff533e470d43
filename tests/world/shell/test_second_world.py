"""Two worlds of one run: one is refused, or both have all robots stand until one has left."""

import itertools
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace

import msgspec
import pytest

from agents.shell.node import RobotNode
from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.run.operator import Operator, probe
from protocol import joining
from protocol.bus.bus import Query, Sample
from protocol.bus.connection import Connection, Endpoint
from protocol.bus.local import LocalNetwork
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode, encode
from protocol.errors import BusError, RunTakenError
from protocol.keys import robot_key, world_key, world_token
from protocol.messages import Command, GoalStatus, Message, PlacedObstacle, Result, Tick
from protocol.operations import Reply, decode_operation
from protocol.scenario.model import Operation
from tests.listening import overhear
from tests.mortal import Death, Doom, DoomedFleet
from tests.system.orders.turnover import asked, step
from world.process import look_for_others
from world.shell import node as shell
from world.shell.checkpoint import Checkpoint
from world.shell.node import WorldNode
from world.shell.operations import OTHER_WORLD
from world.shell.run import drawn_epoch

SWAP = load("swap-4")


@pytest.fixture(autouse=True)
def epochs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coordinators are numbered in the order in which they begin."""
    numbers = itertools.count(1)
    monkeypatch.setattr(shell, "drawn_epoch", lambda **_: next(numbers))


def test_a_running_world_stands_while_another_is_there_and_goes_on_after_that() -> None:
    fleet, said = LocalFleet(SWAP), list[str]()
    fleet.world._operations._warn = said.append
    step(fleet, 10)
    bus = fleet.network.connect()
    other = bus.node = WorldNode(bus, "local", SWAP)
    step(fleet, 3)
    assert other.refused, "it has not begun, and came later"
    assert (fleet.world.world.halted, said) == (True, [f"tick 10: {OTHER_WORLD}"])
    before = fleet.world.world.simulation.places
    released = asked(fleet, {"release": 0})
    assert (released.accepted, released.halted, released.text) == (False, True, OTHER_WORLD)
    step(fleet, 5)
    assert fleet.world.world.simulation.places == before
    bus.close()
    step(fleet, 5)
    assert (fleet.world.world.halted, fleet.world.world.simulation.places != before) == (False, True)
    assert "goes on" in said[-1]


def test_a_world_without_robots_leaves_the_run_to_the_world_that_has_them() -> None:
    """Its own epoch is the lower one, as if it had begun first."""
    fleet = LocalFleet(SWAP)
    fleet.world._session = "00000009"
    step(fleet, 10)
    bus = fleet.network.connect()
    other = bus.node = WorldNode(bus, "local", SWAP, gathering=0.5)
    fleet.network.run(lambda: other.finished)
    assert (other.refused, other.report) == (True, None)
    step(fleet, 3)


@pytest.mark.parametrize("continue_", [(False, False), (True, False), (False, True), (True, True)])
def test_of_two_worlds_before_their_first_tick_one_leaves_and_not_the_one_that_continues(
    continue_: tuple[bool, bool], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shell, "drawn_epoch", drawn_epoch)
    network = LocalNetwork()

    def world(path: Path | None) -> WorldNode:
        bus = network.connect()
        kept = None if path is None else Checkpoint(path, "local", SWAP)
        bus.node = WorldNode(bus, "local", SWAP, checkpoint=kept)
        return bus.node

    paths = [tmp_path / str(index) if each else None for index, each in enumerate(continue_)]
    for path in paths:
        if path is not None:
            Checkpoint.create(path)
            checkpoint, bus = Checkpoint(path, "local", SWAP), network.connect()
            before = WorldNode(bus, "local", SWAP, checkpoint=checkpoint)
            before.handle(Query(world_key("local", "operation"), b"", lambda _: None))  # is written
            bus.close()
            checkpoint.close()
    worlds = [world(path) for path in paths]
    network.run(lambda: any(each.refused for each in worlds))
    stays = [each for each, leaves in zip(continue_, worlds, strict=True) if not leaves.refused]
    assert stays == [any(continue_)]


def test_an_emergency_stop_outlasts_the_other_world() -> None:
    fleet, said = LocalFleet(SWAP), list[str]()
    fleet.world._operations._warn = said.append
    step(fleet, 10)
    bus = fleet.network.connect()
    bus.announce("disknav/local/world/alive/another")
    assert asked(fleet, {"halt": True}).halted
    step(fleet, 3)
    assert not asked(fleet, {"release": 1}).accepted
    bus.close()
    step(fleet, 3)
    assert (asked(fleet).halted, asked(fleet).moving, said[-1][-13:]) == (True, (), "stays stopped")
    assert not asked(fleet, {"release": 1}).halted


def test_a_stop_and_an_order_of_which_anyone_heard_outlast_their_world(tmp_path: Path) -> None:
    fleet = DoomedFleet(SWAP, tmp_path / "checkpoint", Doom())
    step(fleet, 10)
    for order in {"halt": True}, {"goal": {"robot": 1, "points": [[0.0, 0.1]]}}:
        fleet.doom = Doom([0])  # it dies as it publishes next
        with pytest.raises(Death):
            asked(fleet, order)
        fleet.kill_world()
        fleet.start_world()
    step(fleet, 3)
    assert (asked(fleet).halted, [goal.number for goal in asked(fleet).goals]) == (True, [1, 0, 0, 0])


def test_a_robot_does_not_choose_between_two_worlds() -> None:
    network = LocalNetwork()
    for _ in range(2):
        bus = network.connect()
        bus.node = WorldNode(bus, "local", SWAP)
    robot = RobotNode(network.connect(), "local", 1)
    robot.on_timer(robot.deadline)
    assert robot.core is None


def test_what_another_coordinator_or_its_robots_say_does_not_count(caplog: pytest.LogCaptureFixture) -> None:
    fleet = LocalFleet(SWAP)
    step(fleet, 10)
    robot, tick = fleet.robots[2].node, fleet.world.world.tick
    heard = list[Message]()
    overhear(fleet.network, lambda *said: heard.append(decode(*said)), robot_key("local", 1, "state"))
    step(fleet, 1)
    foreign = msgspec.structs.replace(heard[-1], epoch=77, tick=tick + 5)
    assert (robot._health().published, robot._health().received) == (22, 44)
    robot.handle(Sample(robot_key("local", 2, "tick"), encode(Tick(2, 1, tick + 5, (), 77))))
    robot.handle(Sample(robot_key("local", 1, "state"), encode(foreign)))
    assert robot.core.tick <= tick + 1
    robot.handle(Sample(robot_key("local", 9, "state"), encode(msgspec.structs.replace(foreign, robot=9))))
    assert robot._rejected == {"epoch": 2, "identity": 1}
    assert caplog.messages == []
    fleet.world.handle(
        Sample(robot_key("local", 2, "command"), encode(Command(2, 1, tick + 1, (9.0, 0.0), 77)))
    )
    assert fleet.world._run.rejected["epoch"] == 1
    assert fleet.execute()["collisions"] == 0


def test_a_robot_does_not_go_back_to_a_coordinator_that_it_has_left(tmp_path: Path) -> None:
    """A world that was frozen may come back when another one has taken its place."""
    network = LocalNetwork()
    older, path = network.connect(), tmp_path / "checkpoint"
    Checkpoint.create(path)
    checkpoint = Checkpoint(path, "local", SWAP)
    older.node = WorldNode(older, "local", SWAP, checkpoint=checkpoint)
    bus, newer = network.connect(), network.connect()
    robot = bus.node = RobotNode(bus, "local", 1)
    robot.on_timer(robot.deadline)
    assert robot.core.epoch == 1
    with pytest.raises(RunTakenError, match="end that one first"):
        look_for_others(bus, "local")  # with a copy of its checkpoint
    frozen, older.announced, older.served = (older.announced, older.served), [], []
    look_for_others(bus, "local")
    network.publish_presence("disknav/local/world/alive/00000001", False, older)
    checkpoint.close()
    newer.node = WorldNode(newer, "local", SWAP, checkpoint=Checkpoint(path, "local", SWAP))
    bus.drain()
    robot.on_timer(robot.deadline)
    assert robot.core.epoch == 2
    older.announced, older.served = frozen
    network.publish_presence("disknav/local/world/alive/00000001", True, older)
    newer.drain()
    assert newer.node.world.halted, "both have their robots stand"
    newer.close()
    bus.drain()
    with pytest.raises(BusError, match="another run has the name"):
        robot.on_timer(robot.deadline)
    assert robot.core.epoch == 2


class Answers:
    """A bus on which worlds answer as they are told; none does in a round without replies."""

    def __init__(self, *rounds: tuple[Reply, ...]) -> None:
        self.rounds = list(rounds)
        self.events: list[Sample] = []
        self.asked: list[tuple[bytes, bool]] = []
        self.waited: list[float] = []
        self.announced: list[str] = []

    def ask(self, key: str, payload: bytes, timeout: float, *, once: bool) -> list[bytes]:
        self.asked.append((payload, once))
        self.waited.append(timeout)
        replies = self.rounds.pop(0) if len(self.rounds) > 1 else self.rounds[0]
        if not replies:
            raise BusError("no answer")
        return [msgspec.msgpack.encode(reply) for reply in replies]

    def subscribe(self, *keys: str) -> None: ...

    def tokens(self, _: str) -> list[str]:
        return self.announced

    def receive(self, _: object) -> Sample | None:
        return self.events.pop(0) if self.events else None


def test_a_stop_is_repeated_until_all_of_all_worlds_stand() -> None:
    said: list[str] = []
    moving, stands = Reply(True, tick=4, halted=True, moving=(2, 3)), Reply(True, tick=5, halted=True)
    bus = Answers(
        (), (moving,), (), (stands, Reply(True, tick=9, halted=False)), (stands, moving), (stands, stands)
    )
    told = Operator(bus, "r", said.append).stop(60.0)  # type: ignore[arg-type]
    assert told == stands
    assert len(bus.rounds) == 1
    assert not any(once for _, once in bus.asked)
    assert said[0].startswith("no world of run 'r' answers: no answer")
    assert said[1:] == ["2 worlds of run 'r' answer: end all but one"]
    bus = Answers((Reply(True, tick=4, halted=True, moving=(3, 7)), moving))
    told = Operator(bus, "r", print).stop(0.0)  # type: ignore[arg-type]
    assert (told.halted, told.moving) == (True, (2, 3, 7)), "without effect it names those that move"


def test_who_misspells_a_run_hears_soon_which_runs_there_are_and_the_stop_is_sent_again() -> None:
    said, bus = list[str](), Answers((), (), (Reply(True, tick=5, halted=True),))
    bus.announced = [world_token("yard", "1"), world_token("dock", "2")]
    assert Operator(bus, "yrad", said.append).stop(60.0).halted  # type: ignore[arg-type]
    (told,) = said
    assert told.startswith("no world of run 'yrad' answers (runs with a world: dock, yard): ")
    assert told.endswith("; asks again")
    assert bus.waited == [2.0, 5.0, 5.0]
    bus.rounds, bus.announced = [()], [world_token("yrad", "1")]
    with pytest.raises(BusError, match="no world of run 'yrad' answers: "):
        Operator(bus, "yrad", said.append).stop(0.0)  # type: ignore[arg-type]


def test_who_misspells_a_run_to_probe_hears_which_runs_there_are(endpoint: str) -> None:
    connection = Connection(connect=(Endpoint(endpoint),))
    with closing(ZenohBus(connection)) as bus:
        bus.announce(world_token("yard", "1"))
        with pytest.raises(BusError, match=r"for 0\.1 s \(runs with a world: yard\)"):
            probe(connection, "yrad", "robot-3", 0.1)


def test_a_release_lifts_no_stop_that_may_have_come_after_it(monkeypatch: pytest.MonkeyPatch) -> None:
    class Late(Answers):
        delay = 2.5

        def ask(self, key: str, payload: bytes, timeout: float, *, once: bool) -> list[bytes]:
            clock.now += self.delay
            return super().ask(key, payload, timeout, once=once)

    clock = SimpleNamespace(now=0.0, monotonic=lambda: clock.now)
    monkeypatch.setattr("deploy.run.operator.time", clock)
    bus = Late((Reply(True, tick=4, halted=True, stops=3), Reply(True, tick=4, halted=True, stops=2)))
    operator = Operator(bus, "r", print)  # type: ignore[arg-type]
    with pytest.raises(BusError, match="answered after more than 2 s"):
        operator.operate(Operation(halt=False))
    bus.delay = 0.5
    operator.operate(Operation(halt=False))
    asked = [(payload and decode_operation(payload), once) for payload, once in bus.asked]
    assert asked == [(b"", False), (b"", False), (Operation(release=2), True)]


def test_what_became_of_an_order_is_asked_while_its_world_may_be_restarted() -> None:
    goal = GoalStatus(1, 4, 1, "arrived", (0.0, 0.0))
    there = Reply(True, tick=4, obstacles=(PlacedObstacle(1, "standing", ((0.0, 0.0),)),), goals=(goal,))
    Operator(Answers((), (there,)), "r").stands(1, 60.0)  # type: ignore[arg-type]
    ahead = Reply(True, tick=4, goals=(GoalStatus(1, 4, 1, "under way", (0.0, 0.0)),))
    operator = Operator(Answers((ahead,), (), (there,)), "r")  # type: ignore[arg-type]
    assert operator.outcome(1, 1, 60.0) == goal, "also if the world died before it published that"
    cancelled = GoalStatus(1, 5, 2, "cancelled", (0.0, 0.0))  # by an order of its own
    assert Operator(Answers((Reply(True, tick=5, goals=(cancelled,)),)), "r").outcome(1, 1, 60.0) == cancelled  # type: ignore[arg-type]
    for robot, number in ((7, 1), (1, 2)):
        with pytest.raises(BusError, match=f"there is no robot {robot} with order {number}, or no longer"):
            operator.outcome(robot, number, 60.0)
    second = GoalStatus(1, 9, 2, "arrived", (0.1, 0.0))
    late = Answers((Reply(True, tick=8, goals=(msgspec.structs.replace(second, status="under way"),)),))
    published = goal, GoalStatus(3, 9, 2, "arrived", (0.0, 0.0)), second  # of an earlier order, another robot
    late.events = [Sample(robot_key("r", each.robot, "goalstatus"), encode(each)) for each in published]
    assert Operator(late, "r").outcome(1, 2, 60.0) == second  # type: ignore[arg-type]
    ended = Answers((ahead,))
    ended.events = [Sample(world_key("r", "result"), encode(Result("{}")))]
    with pytest.raises(BusError, match="run 'r' is over"):
        Operator(ended, "r").outcome(1, 1, 60.0)  # type: ignore[arg-type]
    with pytest.raises(BusError, match="robot 7 was accepted, but has not appeared: it was removed"):
        operator.appeared(7, 60.0)
    away = Operator(Answers(()), "r")  # type: ignore[arg-type]
    away._heard = -1e9
    with pytest.raises(BusError, match="obstacle 1 was accepted, but has not appeared: no world of run 'r'"):
        away.stands(1, 1e6)
    with pytest.raises(BusError, match="may still take effect: see `disknav monitor r`"):
        away.operate(Operation(halt=True))


def test_a_join_request_names_a_session_that_can_stand_in_a_key() -> None:
    world, replies = WorldNode(LocalNetwork().connect(), "local", SWAP), list[bytes]()
    request = joining.encode_request(joining.Join(1, "a/b"))
    world.handle(Query(robot_key("local", 1, "join"), request, replies.append))
    assert "session" in joining.decode_reply(replies[0]).text  # type: ignore[union-attr]
