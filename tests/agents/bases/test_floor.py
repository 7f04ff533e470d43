"""Robots with external bases, in virtual time: whatever is late, lost, wrong or dead, nothing touches."""

import math
import re
from itertools import count
from random import Random

import pytest

from agents.bases.ros_messages import Odometry, StampedPose
from tests.agents.bases.floor import Floor
from tests.agents.bases.test_senses import ODOMETRY, PAIR, POSE, fleet, shifted
from world.report import result_of

pytestmark = pytest.mark.slow

FROM, UNTIL = 8.0, 10.0  # s, of what goes wrong
STOPPED = 1.2  # s after which a base that is left alone stands: silence, hold, braking


def test_six_robots_swap_although_messages_are_late_and_lost():
    floor = Floor(fleet(6), 3, delay=0.1, loss=0.1).run(120.0)
    report = result_of(floor.world)
    assert report["verdict"] == "arrived"
    assert floor.closest > 0.0
    assert floor.excess <= 0.0  # each robot's set held the truth all the time
    assert floor.strayed <= 0.0  # and its wheels did what the filter counts on
    assert report["plant"]["kind"] == "external"
    assert 0.0 < report["plant"]["reported_bound"] < 0.02  # as the result says of what it was judged by
    assert report["min_clearance"] == pytest.approx(floor.closest, abs=2 * report["plant"]["reported_bound"])


@pytest.mark.campaign
def test_six_robots_that_know_little_of_their_places_do_not_hold_each_other():
    bounds = ("sensing.noise_bound=0.01", "base.latency=0.04", "base.patience=0.15", "base.age=0.12")
    floor = Floor(fleet(6, *bounds, "world.lease=0.8", "control.law=reciprocal"), 7).run(45.0)
    assert result_of(floor.world)["verdict"] == "arrived"
    assert floor.closest > 0.0


def test_commands_that_come_when_their_tick_is_over_are_signs_of_life():
    floor = Floor(PAIR, 1, delay=0.3).run(120.0)
    assert result_of(floor.world)["verdict"] == "arrived"
    assert floor.closest > 0.0


def during(change):
    """Change every other message to robot 1 for a while; or all, if that is to lose them."""
    number = count()

    def changed(robot: int, now: float, message: Odometry | StampedPose):
        if robot != 1 or not FROM <= now < UNTIL:
            return message
        other = change(message)
        return message if other is not None and next(number) % 2 else other

    return changed


@pytest.mark.parametrize(
    ("stream", "what"), [("odometry", "jumps"), ("odometry", "stops"), ("pose", "contradicts odometry")]
)
def test_a_robot_stands_while_a_stream_is_unsound_says_why_and_goes_on(stream, what):
    change, says = (ODOMETRY if stream == "odometry" else POSE)[what]
    floor = Floor(PAIR, 2, **{stream: during(change)}).run(FROM)
    assert floor.moving() == [1, 2]
    floor.run(FROM + STOPPED)
    crew = floor.crews[1]
    assert 1 not in floor.moving()
    assert crew.base.senses.fault
    assert any(re.search(says, note) for note in crew.notes), crew.notes
    floor.run(UNTIL + 5.0)
    assert crew.notes[-1] == ""
    assert 1 in floor.moving()
    assert floor.closest > 0.0
    assert floor.excess <= 0.0


def test_a_robot_stands_while_its_odometry_comes_later_and_later_and_then_late_alike():
    """No message is lost, none is unsound, and one arrives every 20 ms; the clocks are years apart."""
    floor = Floor(PAIR, 2, held_up=lambda robot, now: late(now) if robot == 1 else 0.0).run(FROM)
    assert floor.moving() == [1, 2]
    floor.run(FROM + STOPPED)
    assert 1 not in floor.moving()
    floor.run(FROM + 20.0)
    assert 1 not in floor.moving()
    assert floor.crews[1].notes[-1].startswith("odometry has become later")
    floor.run(150.0)
    assert floor.crews[1].notes[-1] == ""
    assert result_of(floor.world)["verdict"] == "arrived"
    assert floor.closest > 0.0


class Wavering:
    """A law that drives at the middle or away from it, and at times hardly at all."""

    failure = ""

    def __init__(self, robot: int) -> None:
        self._draw, self._wish, self._left = Random(robot), (0.0, 0.0), 0

    def velocity(self, view):
        self._left -= 1
        if self._left < 0:
            self._left = self._draw.randint(0, 5)
            x, y = view.position
            angle = math.atan2(-y, -x) + self._draw.uniform(-0.5, 0.5)
            speed = self._draw.choice((0.2, 0.2, -0.2, 0.004, 0.0))
            self._wish = speed * math.cos(angle), speed * math.sin(angle)
        return self._wish

    def slice_norm(self, *_):
        return 0.0


@pytest.mark.parametrize("age", [0.1, pytest.param(0.6, marks=pytest.mark.campaign)])
def test_wheels_do_what_the_filter_counts_on_with_odometry_as_old_as_it_may_be(age):
    def held_up(_, now):
        return min(age - 0.01, max(0.0, 0.5 * (now - 3.0)))

    floor = Floor(fleet(2, f"base.age={age}", "time.endless=true"), 1, delay=0.01, held_up=held_up)
    for robot, crew in floor.crews.items():
        crew.core._law = Wavering(robot)
    floor.run(20.0)
    assert floor.strayed <= 1e-6  # servos come to rest in no finite time
    assert floor.excess <= 0.0
    assert floor.closest > 0.0


def late(now: float) -> float:
    """A delay that grows for a second and goes on for 20 s, s."""
    return min(0.3 * (now - FROM), 0.3) if FROM <= now < FROM + 20.0 else 0.0


def test_a_localisation_that_drifts_off_contradicts_itself_in_the_end_and_is_begun_anew():
    """No two poses exclude each other; all together do, in the robot's own set."""
    drift = count()

    def pose(robot: int, now: float, message: StampedPose):
        away = robot == 1 and FROM <= now < UNTIL
        return shifted(message, min(0.04, 2e-3 * next(drift))) if away else message

    floor = Floor(PAIR, 2, pose=pose).run(120.0)
    assert any("the measurement of tick" in note for note in floor.crews[1].notes)
    assert floor.crews[1].notes[-1] == ""
    assert not floor.crews[1].core.lost
    assert result_of(floor.world)["verdict"] == "arrived"
    assert floor.closest > 0.0


def test_a_base_that_dies_is_stood_by_and_one_that_comes_back_is_driven_on():
    floor = Floor(PAIR, 4).run(FROM)
    floor.crews[1].wheels.dead = True
    floor.run(FROM + 20.0)
    assert floor.crews[1].base.senses.fault == "no odometry for 0.5 s"
    assert floor.closest > 0.0
    floor.crews[1].wheels.dead = False
    assert result_of(floor.run(150.0).world)["verdict"] == "arrived"
    assert floor.closest > 0.0


def test_a_fleet_cut_off_from_its_coordinator_stands_within_hold_and_braking_and_then_drives_on():
    floor = Floor(fleet(4), 5).run(FROM)
    floor.cut = True
    body = floor.scenario.body_of(1)
    floor.run(FROM + floor.delay + floor.scenario.time.step + body.hold + body.speed / body.acceleration)
    assert floor.moving() == []
    floor.run(FROM + 4.0)
    assert len(floor.world.lives.roster.standing) == 4
    floor.cut = False
    assert result_of(floor.run(200.0).world)["verdict"] == "arrived"
    assert floor.closest > 0.0


def test_a_robot_does_not_move_on_ticks_that_come_when_it_is_fenced():
    """They were under way for longer than its coordinator waited for it."""
    floor = Floor(fleet(3), 1).run(FROM)
    floor.late = 1
    floor.run(FROM + 3.0)
    floor.cut = True
    del floor.held[5:]
    floor.release()
    told = {floor.run(FROM + 3.0 + 0.01 * step).crews[1].wheels.aims for step in range(100)}
    assert told == {(0.0, 0.0)}


@pytest.mark.parametrize(
    "seed", [0, pytest.param(1, marks=pytest.mark.campaign), pytest.param(2, marks=pytest.mark.campaign)]
)
def test_a_process_that_was_stopped_is_fenced_where_it_is_and_does_not_move_on_stale_ticks(seed):
    floor = Floor(fleet(3), seed).run(FROM)
    floor.crews[1].alive = False
    floor.run(FROM + 3.0)
    (member,) = [each for each in floor.world.lives.roster.message.members if each.status == "standing"]
    place = floor.crews[1].wheels.control
    assert member.robot == 1
    assert math.dist(member.position, place) <= member.bound
    floor.cut = True  # all that it has is what it missed
    floor.thaw(1)
    floor.run(FROM + 5.0)
    assert math.dist(floor.crews[1].wheels.control, place) < 1e-6
    floor.cut = False
    floor.run(200.0)
    assert floor.closest > 0.0
