"""Robots that come and go while the fleet runs: announced, cleared, put down, joined, removed."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from agents.shell.node import RobotNode
from deploy.library.load import load, resolved
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.operator import operating
from deploy.run.options import RunOptions, Transport
from deploy.studies.falsify.runs.observe import observe
from deploy.studies.falsify.runs.skipped_waits import skipped_waits
from protocol.bus.connection import Connection
from protocol.messages import Clock
from protocol.requests.fleet import FleetReply, decode_change
from protocol.requests.joining import Join, Wait
from protocol.scenario.body import Body
from protocol.scenario.file import parse_toml
from protocol.scenario.model import Order, ProcessFault, RobotSpec, Scenario
from tests.deploy.run.orders.turnover import Turnover, asked
from tests.world.stopwatch import Stopwatch
from world.shell.admission import Admissions
from world.shell.failure_detector import GATHERING
from world.shell.persistence.journal import Journal
from world.shell.run import Run

SWAP = load("swap-4")
GUEST = RobotSpec(7, 0.03, (0.0, 0.0), (0.0, 0.22))  # where the four of them pass
COMINGS = [(0.2, {"add": GUEST}), (1.0, {"remove": 7}), (1.3, {"add": GUEST})]
GUESTED = replace(SWAP, orders=(Order(0.2, add=GUEST),))
AT_ONCE = replace(SWAP, orders=tuple(Order(at, **order) for at, order in COMINGS))


def status(fleet: LocalFleet, robot: int) -> str:
    return next((each.status for each in asked(fleet).roster.members if each.robot == robot), "")


def step(fleet: LocalFleet, ticks: int) -> None:
    for _ in range(ticks):
        assert fleet.step()


def to_be(fleet: LocalFleet, robot: int, wanted: str, most: int = 400) -> None:
    for _ in range(most):
        if status(fleet, robot) == wanted:
            return
        assert fleet.step()
    pytest.fail(f"robot {robot} is {status(fleet, robot)}, not {wanted}")


def guested(tick: int, seed: int = 0) -> dict[str, Any]:
    """The report of a run that takes in a guest at a tick."""
    fleet = LocalFleet([replace(SWAP, seed=seed)])
    step(fleet, tick)
    assert asked(fleet, {"add": GUEST}).accepted
    return fleet.execute()[0]


def test_a_guest_appears_joins_and_arrives() -> None:
    report = guested(20)
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert report["robots"] == [1, 2, 3, 4, 7]
    assert math.dist(report["positions"]["7"], GUEST.goal) <= SWAP.time.tolerance
    assert report["min_clearance"] > 0.0


def test_who_is_removed_and_added_again_at_once_has_a_process_of_its_own() -> None:
    """Also if the ticks between are so few, or so quick, that no Clock says that nobody is to come."""
    began = time.monotonic()
    report = LocalFleet([AT_ONCE]).execute()[0]
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert time.monotonic() - began < GATHERING  # nobody was waited for in vain


def test_a_process_that_is_there_before_its_disk_waits_for_it() -> None:
    fleet = LocalFleet([SWAP])
    step(fleet, 10)
    assert asked(fleet, {"add": GUEST}).accepted
    process = fleet.start(7)
    process.wake(math.inf)  # asks to join
    assert status(fleet, 7) == "appearing"
    to_be(fleet, 7, "standing")
    process.wake(math.inf)
    report = fleet.execute()[0]
    assert (report["verdict"], report["robots"]) == ("arrived", [1, 2, 3, 4, 7])


def test_a_process_that_is_there_before_its_order_waits_and_no_trajectory_shows_it() -> None:
    fleet = LocalFleet([GUESTED])
    process = fleet.start(7)
    for _ in range(10):
        process.wake(math.inf)  # asks to join: who is refused again and again gives up
    report = fleet.execute()[0]
    assert (report["verdict"], report["robots"]) == ("arrived", [1, 2, 3, 4, 7])
    assert report["trajectory_sha256"] == LocalFleet([GUESTED]).execute()[0]["trajectory_sha256"]
    assert fleet.robots[7].node is process
    assert isinstance(process, RobotNode)
    assert process.verdict == "arrived"


def test_no_trajectory_shows_who_asks_between_two_ticks_while_nobody_takes_part() -> None:
    """What the scenario does as a tick opens comes before anybody is admitted: here it pauses a guest at
    once. The others were fenced, and come back while it is paused."""
    times = (*((robot, 1.0, 2.3) for robot in SWAP.ids), (7, 2.05, 2.55))
    faults = [ProcessFault(robot, at, "pause") for robot, at, _ in times]
    faults += [ProcessFault(robot, until, "resume") for robot, _, until in times]
    orders, time_ = (Order(2.0, add=GUEST),), replace(SWAP.time, endless=True)
    scenario = replace(SWAP, orders=orders, process=tuple(faults), time=time_)
    found = []
    for early in (False, True):
        with skipped_waits():
            fleet = LocalFleet([scenario])
            core = fleet.world.world.coordinator
            process = fleet.start(7) if early else None
            fleet.network.run(lambda core=core: bool(core.membership.newcomers))  # type: ignore[misc]
            assert not core.active
            if process is not None:
                process.wake(math.inf)  # asks to join
            fleet.network.run(lambda core=core: core.tick >= 160)  # type: ignore[misc]
        fleet.world.interrupt("interrupted", "")
        assert (41, 7, "pause") in [(tick, fault.robot, fault.event) for tick, fault in core.lives.applied]
        found.append((core.tick, fleet.reports[0]["trajectory_sha256"]))
    assert found[0] == found[1]


@pytest.mark.parametrize("following", [(), (SWAP,)], ids=["the last run", "a run without it"])
def test_who_waits_for_an_order_that_never_comes_is_told_so(following: tuple[Scenario, ...]) -> None:
    short = replace(GUESTED, time=replace(SWAP.time, limit=0.15))
    fleet = LocalFleet([short, *following])
    process = fleet.start(7)
    process.wake(math.inf)
    began = time.monotonic()
    reports = fleet.execute()
    assert [report["verdict"] for report in reports] == ["timeout", *["arrived" for _ in following]]
    assert isinstance(process, RobotNode)
    process.wake(math.inf)
    assert process.verdict == ("removed" if following else "timeout")
    assert time.monotonic() - began < GATHERING


def test_a_process_that_has_died_before_its_order_keeps_nobody_waiting() -> None:
    clock = Stopwatch()
    admissions, run = Admissions("r", SWAP.ids, True, clock), Run(0, GUESTED, {})
    reply = admissions.refusal(Join(7, "dies", None), run)
    assert isinstance(reply, Wait)
    assert not admissions.missing()
    assert 7 not in admissions.absent()
    assert admissions.is_asked_soon()
    clock.now = reply.after * 10
    assert not admissions.is_asked_soon()
    admissions.refusal(Join(7, "lives", None), run)
    admissions.expect(7)
    assert admissions.is_asked_soon()
    assert admissions.refusal(Join(7, "lives", None), run) is None  # its disk is there
    assert not admissions.is_asked_soon()


@pytest.mark.parametrize("again", [False, True], ids=["leaves with the run", "comes in each"])
def test_a_guest_of_one_run_is_none_of_the_next(again: bool) -> None:
    guested = replace(SWAP, orders=(Order(0.2, add=GUEST),))
    reports = LocalFleet([guested, guested if again else SWAP]).execute()
    assert [report["verdict"] for report in reports] == ["arrived", "arrived"]
    assert [len(report["robots"]) for report in reports] == [5, 5 if again else 4]


def test_a_guest_of_a_later_run_lives_no_life_of_an_earlier_one() -> None:
    """Else a process that missed the end of its run would go on as the other one, by its old lines."""
    guested = replace(SWAP, orders=(Order(0.2, add=GUEST),))
    fleet = LocalFleet([guested, SWAP, guested])
    lives: list[int] = []
    fleet.network.run(lambda: fleet.world.finished or 7 in fleet.world.world.coordinator.lives.up)
    lives.append(fleet.world.world.coordinator.lives.of[7].incarnation)
    fleet.network.run(lambda: fleet.world.finished or 7 not in fleet.world.world.coordinator.lives.up)
    fleet.network.run(lambda: fleet.world.finished or 7 in fleet.world.world.coordinator.lives.up)
    lives.append(fleet.world.world.coordinator.lives.of[7].incarnation)
    assert lives == [1, 2]
    assert fleet.world._run.oldest[7] == 2  # what the first one said is of an earlier run


def test_a_guest_that_appears_as_the_run_ends_is_told_that_it_is_over() -> None:
    """A robot that was removed while it was paused keeps the world waiting for what it reports."""
    orders = (Order(0.0, add=GUEST), Order(0.0, remove=2))
    pause = (ProcessFault(2, 0.0, "pause"),)
    for limit in range(1, 6):
        time_ = replace(SWAP.time, limit=limit * SWAP.time.step)
        with skipped_waits():
            fleet = LocalFleet([replace(SWAP, time=time_, orders=orders, process=pause)])
            assert [report["verdict"] for report in fleet.execute()] == ["timeout"]


def test_who_followed_a_paused_process_is_there_for_the_next_scenario() -> None:
    """Its robot is removed and added again, and appears as the first scenario ends."""
    again = SWAP.spec(2)
    orders = (Order(0.0, remove=2), Order(0.0, add=again))
    faults = (ProcessFault(2, 0.0, "pause"), ProcessFault(2, 0.0, "restart"))
    for limit in range(1, 8):
        time_ = replace(SWAP.time, limit=limit * SWAP.time.step)
        first = replace(SWAP, time=time_, orders=orders, process=faults)
        with skipped_waits():
            reports = LocalFleet([first, SWAP]).execute()
        assert [report["verdict"] for report in reports] == ["timeout", "arrived"]


def test_no_fault_that_the_world_passes_over_ends_the_process_of_the_next_robot() -> None:
    """However late a launcher gets to the first: robot 2 is not there, and its next process comes."""
    text = """
        time = { step = 0.05, limit = 0.3 }
        workspace = { radius = 3.0 }
        process = [{ robot = 2, at = 0.04, event = "restart" }, { robot = 2, at = 0.053, event = "restart" }]
        robots = [
            { id = 1, radius = 0.3, start = [0.0, 1.0], goal = [0.0, 0.0] },
            { id = 2, radius = 0.3, start = [0.0, 0.0], goal = [0.0, -1.0] },
        ]
        [[orders]]
        at = 0.0
        remove = 2
        [[orders]]
        at = 0.05
        add = { id = 2, radius = 0.09, start = [0.0, 0.0], goal = [0.0, 1.0] }
    """
    scenario = resolved(parse_toml(text))
    calm = observe(scenario)
    assert calm.report is not None
    assert calm.report["faults"]["given_up"] == []
    assert [fault["tick"] for fault in calm.report["faults"]["process"]] == [2]
    assert {observe(scenario, busy=seed).trajectory for seed in range(1, 16)} == {calm.trajectory}


@pytest.mark.parametrize("event", ["restart", "kill", "resume"])
def test_a_newcomer_that_is_paused_has_no_process_before_it_may_join(event: str) -> None:
    """One that were started, and waited, might be ended by the next fault, or join just before."""
    text = f"""
        time = {{ step = 0.05, limit = 1.0 }}
        workspace = {{ radius = 3.0 }}
        process = [{{ robot = 2, at = 0.05, event = "pause" }}, {{ robot = 2, at = 0.25, event = "{event}" }}]
        robots = [
            {{ id = 1, radius = 0.3, start = [0.0, -1.0], goal = [0.0, -1.5] }},
            {{ id = 3, radius = 0.3, start = [1.0, -1.0], goal = [1.0, -1.5] }},
        ]
        [[orders]]
        at = 0.0
        add = {{ id = 2, radius = 0.09, start = [0.0, 0.0], goal = [0.0, 1.0] }}
    """
    scenario = resolved(parse_toml(text))
    calm = observe(scenario)
    assert calm.report is not None
    assert calm.report["faults"]["given_up"] == []
    assert {observe(scenario, busy=seed).trajectory for seed in range(1, 9)} == {calm.trajectory}


@pytest.mark.slow
def test_who_was_removed_takes_part_in_the_next_scenario_that_has_it() -> None:
    without = replace(SWAP, orders=(Order(0.3, remove=2),))
    reports = LocalFleet([without, SWAP]).execute()
    assert [report["robots"] for report in reports] == [[1, 3, 4], [1, 2, 3, 4]]
    with Fleet([without, SWAP], RunOptions("routed")) as fleet:
        found = fleet.execute()
    for report, same in zip(reports, found, strict=True):
        assert report["verdict"] == same["verdict"] == "arrived"
        assert report["trajectory_sha256"] == same["trajectory_sha256"]


@pytest.mark.slow
def test_so_it_has_among_real_processes() -> None:
    for _ in range(4):
        with Fleet([AT_ONCE], RunOptions("routed")) as fleet:
            (report,) = fleet.execute()
        assert (report["verdict"], report["faults"]["given_up"]) == ("arrived", [])


def test_the_same_change_at_the_same_tick_gives_the_same_trajectory() -> None:
    found = [guested(tick)["trajectory_sha256"] for tick in (20, 20, 21)]
    assert found[0] == found[1] != found[2]


def test_nothing_appears_while_somebody_is_in_its_place() -> None:
    fleet = LocalFleet([replace(SWAP, time=replace(SWAP.time, endless=True))])
    step(fleet, 5)
    (x, y), *_ = fleet.world.world.truth.positions
    assert asked(fleet, {"add": replace(GUEST, start=(x, y), goal=(x, y))}).accepted
    step(fleet, 1)
    assert status(fleet, 7) == "appearing"
    to_be(fleet, 7, "live")  # who is there makes room
    assert fleet.world.world.report()["collisions"] == 0


def test_who_is_removed_ends_and_may_come_back() -> None:
    fleet = LocalFleet([replace(SWAP, time=replace(SWAP.time, endless=True))])
    step(fleet, 20)
    node = fleet.robots[2].node
    assert asked(fleet, {"remove": 2}).accepted
    step(fleet, 5)
    assert (status(fleet, 2), fleet.world.world.truth.robots) == ("gone", (1, 3, 4))
    assert (node.finished, node.verdict) == (True, "removed")
    assert asked(fleet, {"add": RobotSpec(2, 0.02, (0.0, -0.2), (0.1, -0.2))}).accepted
    to_be(fleet, 2, "live")
    step(fleet, 40)
    report = fleet.world.world.report()
    assert (report["collisions"], report["robots"]) == (0, [1, 2, 3, 4])
    assert math.dist(report["positions"]["2"], (0.0, -0.2)) > 0.01  # it moves again


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"add": replace(GUEST, id=1)}, "robot 1 is live"),
        ({"add": replace(GUEST, start=(0.43, 0.0))}, "out of the workspace"),
        ({"add": replace(GUEST, goal=(0.0, -0.5))}, "out of the workspace"),
        ({"add": replace(GUEST, radius=-1.0)}, "radius: must be at least 1e-09"),
        ({"add": replace(GUEST, start=(math.nan, 0.0))}, "start[0]: must be at least"),
        ({"add": replace(GUEST, heading=math.nan)}, "heading: must be at least"),
        ({"add": replace(GUEST, body=Body("omnidirectional", acceleration=-1.0))}, "body.acceleration: must"),
        (
            {"add": replace(GUEST, body=Body("differential-drive", offset=0.01))},
            "body.track: must be above 0",
        ),
        ({"add": replace(GUEST, body=Body(radius=0.05))}, "radius: must be at least 0.05"),
        ({"add": replace(GUEST, body=Body(error=0.1))}, "points only"),
        ({"remove": 9}, "no robot 9 in the fleet; there are 1, 2, 3, 4"),
    ],
)
def test_what_cannot_be_is_refused_by_reason_and_changes_nothing(change: dict[str, Any], reason: str) -> None:
    fleet = LocalFleet([SWAP])
    step(fleet, 3)
    before = asked(fleet).roster
    reply = asked(fleet, change)
    assert not reply.accepted
    assert reason in reply.text
    assert reply.roster == before


def test_the_last_one_stays() -> None:
    fleet = LocalFleet([replace(SWAP, time=replace(SWAP.time, endless=True))])
    step(fleet, 3)
    for robot in (1, 2, 3):
        assert asked(fleet, {"remove": robot}).accepted
        step(fleet, 2)
    assert "is the last one" in asked(fleet, {"remove": 4}).text


def test_requests_that_are_none_are_refused() -> None:
    for payload in (b"{}", b'{"add": 3}', b'{"remove": 1, "add": {}}', b"\xc1", b'{"remove": 0}'):
        with pytest.raises(Exception, match="fleet request"):
            decode_change(payload)


def test_a_restarted_world_knows_who_came_and_went(tmp_path: Path) -> None:
    Journal.create(tmp_path / "journal", "local", [SWAP])
    fleet = LocalFleet([SWAP], journal=tmp_path / "journal")
    step(fleet, 10)
    assert asked(fleet, {"add": GUEST}).accepted
    to_be(fleet, 7, "live")
    assert asked(fleet, {"remove": 1}).accepted
    step(fleet, 5)
    before = fleet.world.world
    fleet.kill_world()
    fleet.start_world()
    after = fleet.world.world
    assert (after.truth, after.coordinator.lives.roster.members) == (
        before.truth,
        before.coordinator.lives.roster.members,
    )
    report = fleet.execute()[0]
    assert (report["verdict"], report["collisions"], report["robots"]) == ("arrived", 0, [2, 3, 4, 7])


@pytest.mark.parametrize("removed", [False, True], ids=["who is to come", "who has gone"])
def test_a_restarted_world_can_tell_everybody_whom_its_roster_names(tmp_path: Path, removed: bool) -> None:
    Journal.create(tmp_path / "journal", "local", [SWAP])
    fleet = LocalFleet([SWAP], journal=tmp_path / "journal")
    step(fleet, 10)
    assert asked(fleet, {"add": GUEST}).accepted
    if removed:
        to_be(fleet, 7, "live")
        assert asked(fleet, {"remove": 7}).accepted
        step(fleet, 5)
    fleet.kill_world()
    fleet.start_world()
    report = fleet.execute()[0]
    there = [1, 2, 3, 4] if removed else [1, 2, 3, 4, 7]
    assert (report["verdict"], report["collisions"], report["robots"]) == ("arrived", 0, there)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_comings_and_goings_under_faults(seed: int) -> None:
    turnover = Turnover(seed)
    turnover.run(600)
    assert turnover.fleet.world.world.report()["collisions"] == 0
    assert turnover.changes >= 20
    assert turnover.settles(2400)


# -- on real zenoh


class Guests:
    """Takes a guest in at tick 10, and out again once it has been live for a while."""

    def __init__(self) -> None:
        self.told: list[FleetReply] = []
        self._connection: Connection | None = (
            None  # to those of the beginning: the guest may not be there yet
        )

    def __call__(self, fleet: Fleet, clock: Clock) -> None:
        self._connection = self._connection or fleet.topology.observer()
        comes, goes = clock.tick >= 10 and not self.told, len(self.told) == 1 and 7 in clock.active
        if comes or goes:
            with operating(self._connection, fleet._options.run) as operator:
                self.told.append(operator.add(GUEST) if comes else operator.remove(7))


@pytest.mark.process
@pytest.mark.timeout(120)
@pytest.mark.parametrize("transport", ["routed", "mesh"])
def test_processes_come_and_go(transport: Transport) -> None:
    guests, clocks = Guests(), list[Clock]()
    scenario = replace(load("swap-6"), time=replace(SWAP.time, limit=60.0))
    with Fleet([scenario], RunOptions(transport, speed=4.0), watch=clocks.append) as fleet:

        def enough() -> bool:
            while clocks:
                guests(fleet, clocks.pop(0))
            return False

        report = fleet.execute(enough)[0]
        rows = {row["name"]: row for row in fleet.processes()}
    assert [reply.accepted for reply in guests.told] == [True, True]
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert rows["robot-7"]["exit_code"] == 0
