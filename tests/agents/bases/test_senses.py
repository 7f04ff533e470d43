"""Odometry and poses: how old they are by clocks that were never set, and what is wrong with them."""

import math
import re
from dataclasses import replace
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.bases.ros2 import Ros2Base
from agents.bases.ros_messages import NANO, Odometry, Pose, Velocity, decode, header_at
from agents.bases.senses import DRIFT, SETTLING, LinkDelay, Odometer, Senses, wrapped
from deploy.library.load import load
from protocol.bodies.kinematics import Kinematics
from protocol.messages import Command, Tick
from protocol.scenario.body import DECISION, PRESETS, Base
from tests.agents.bases.wheels import Wheels, turn

DELAYS = st.lists(st.floats(0.0, 0.2), min_size=1, max_size=50)


@given(st.floats(-1e9, 1e9), DELAYS)
def test_the_age_is_that_since_the_stamp_less_the_least_delay_whatever_the_clocks_show(offset, delays):
    link, stamps = LinkDelay(), [0.3 * n for n in range(len(delays))]  # so that none overtakes another
    for stamp, delay in zip(stamps, delays, strict=True):
        link.take(stamp + offset, stamp + delay)
    now = stamps[-1] + 0.5
    drift = DRIFT * 0.5 * (len(delays) + 1)
    assert now - stamps[-1] - link.age(stamps[-1] + offset, now) == pytest.approx(
        min(delays), abs=drift + 1e-6
    )


def test_a_delay_that_has_grown_counts_as_the_least_one_only_minutes_later():
    link = LinkDelay()
    link.take(0.0, 0.01)
    ages = []
    for second in range(1, 1200):
        link.take(float(second), second + 0.31)
        ages.append(link.age(float(second), second + 0.31))
    assert ages[60] > 0.25
    assert ages[-1] == pytest.approx(0.0, abs=1e-9)


def test_a_clock_that_is_set_back_begins_a_new_difference_and_one_set_forward_makes_nothing_old():
    link = LinkDelay()
    for stamp, now in ((100.0, 0.0), (1000.0, 1.0), (20.0, 2.0)):
        link.take(stamp, now)
        assert link.age(stamp, now) == pytest.approx(0.0)
    assert math.isfinite(link.age(20.0, 3.0))


def odometry(stamp: float, x: float) -> Odometry:
    """What a base says at a time, s, that is on the x axis at x, m."""
    pose = Pose([x, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0])
    header = header_at(round(stamp * NANO), "odom")
    return Odometry(header, "base_link", pose, [0.0] * 36, Velocity([0.0] * 3, [0.0] * 3), [0.0] * 36)


@pytest.mark.parametrize(
    ("clock", "silent", "says"),
    [
        (0.0, 0.02, r"odometry jumps by 0\.3"),
        (0.0, 1.0, "odometry pauses for 1 s"),  # in which a base may have come as far
        (-1e9, 0.1, "odometry goes back in time"),
        (0.2, 0.02, r"the clock of odometry jumps ahead by 0\.2"),
        (1e9, 1.0, "odometry pauses for 1e"),
        (-0.1, 0.3, r"odometry pauses for 0\.3"),  # by its own clock, for less
    ],
)
def test_a_publisher_that_begins_again_is_no_motion(clock, silent, says):
    """Its origin is where the base stands by then, its clock any."""
    odometer = Odometer(Base(), PRESETS["turtlebot3-burger"])
    for step in range(50):
        assert odometer.take(odometry(1e9 + 0.02 * step, 0.3), 0.02 * step) == ""
    now = 0.98 + silent
    assert re.match(says, odometer.take(odometry(1e9 + clock + now, 0.0), now))
    odometer.forget()
    for step in range(50):
        later = now + 0.02 * step
        assert odometer.take(odometry(1e9 + clock + later, 0.0), later) == ""


def test_odometry_of_which_some_is_lost_or_late_goes_on():
    odometer = Odometer(Base(), PRESETS["turtlebot3-burger"])
    for stamp, delay in ((0.0, 0.03), (0.02, 0.0), (0.2, 0.3), (0.22, 0.28), (0.4, 0.1)):
        assert odometer.take(odometry(stamp, 0.1 * stamp), stamp + delay) == ""


SETTINGS = (
    "world.plant=external",
    "time.step=0.1",
    "sensing.noise=0.003",
    "sensing.noise_bound=0.006",
    "sensing.heading=0.03",
    "time.limit=120",
    "time.tolerance=0.03",
    "control.speed=0.2",
)


def fleet(count, *settings):
    return load(f"turtlebots-{count}", [*SETTINGS, *settings], 1)


PAIR = fleet(2)


def replace_pose(message, **changes):
    return replace(message, pose=replace(message.pose, **changes))


def shifted(message, by):
    x, y, z = message.pose.position
    return replace_pose(message, position=[x + by, y, z])


def stamped(message, by):
    header = message.header
    return replace(message, header=header_at(header.stamp + round(by * NANO), header.frame))


def framed(message, frame):
    return replace(message, header=replace(message.header, frame=frame))


ODOMETRY = {
    "jumps": (lambda m: shifted(m, 0.5), r"odometry jumps by 0\.5"),
    "stops": (lambda _: None, r"no odometry for 0\.5 s"),
    "goes back in time": (lambda m: stamped(m, -1.0), r"odometry goes back in time by 0\.98"),
    "is no number": (lambda m: shifted(m, math.nan), "odometry that is no number"),
    "has an infinite velocity": (
        lambda m: replace(m, velocity=replace(m.velocity, linear=[math.inf, 0.0, 0.0])),
        "odometry that is no number",
    ),
    "is upside down": (lambda m: replace_pose(m, orientation=[1.0, 0.0, 0.0, 0.0]), "not in the plane"),
    "is on its nose": (lambda m: replace_pose(m, orientation=[0.0, 1.0, 0.0, 0.0]), "not in the plane"),
    "has no direction": (lambda m: replace_pose(m, orientation=[0.0] * 4), "not in the plane"),
    "is in another frame": (lambda m: framed(m, "map"), "odometry of 'base_link' in 'map'"),
    "is of another frame": (lambda m: replace(m, child="laser"), "odometry of 'laser' in 'odom'"),
}
POSE = {
    "contradicts odometry": (
        lambda m: shifted(m, 0.1),
        r"a pose and odometry exclude each other by 0\.0\d+ m",
    ),
    "goes back in time": (lambda m: stamped(m, -1.0), "the pose goes back in time by 0"),
    "is no number": (lambda m: shifted(m, math.nan), "a pose that is no number"),
    "is in another frame": (lambda m: framed(m, "world"), "a pose in 'world', not in 'map'"),
}


@pytest.mark.parametrize(
    ("stream", "what"), [("odometry", what) for what in ODOMETRY] + [("pose", what) for what in POSE]
)
def test_an_unsound_stream_says_why_and_is_trusted_again_after_a_while(stream, what):
    change, says = (ODOMETRY if stream == "odometry" else POSE)[what]
    senses, wheels = Senses(PAIR, 1, Base()), Wheels(PAIR, 1, Random(1))

    def hear(begin, changed=()):
        for number in range(50):
            now = begin + 0.02 * number
            messages = {"odometry": wheels.odometry(now), "pose": wheels.pose(now)}
            for name in changed:
                messages[name] = change(messages[name]) if number % 2 or what == "stops" else messages[name]
            if messages["odometry"] is not None:
                senses.on_odometry(messages["odometry"].serialize(), now)
            senses.on_pose(messages["pose"].serialize())
            senses.look(now)
            yield senses.fault

    assert [*hear(0.0)][-1] == ""
    assert senses.place() is not None
    notes = [*hear(1.0, [stream])]
    assert any(re.search(says, note) for note in notes), notes
    assert (notes[-1] != "", senses.place()) == (True, None)
    later = [*hear(2.0)]
    assert all(later[: round(SETTLING / 0.02)])
    assert later[-1] == ""


OLDEST = PAIR.base_of(1).age + PAIR.base_of(1).latency  # s, of odometry by which to move


@pytest.mark.parametrize(
    ("fault", "life", "aged", "taken", "moves"),
    [
        pytest.param(False, 1, 0.9 * OLDEST, 0.0, True, id="in time"),
        pytest.param(True, 1, 0.0, 0.0, False, id="after a fault in the same tick"),
        pytest.param(False, 2, 0.0, 0.0, False, id="by another life than the coordinator has heard"),
        pytest.param(False, 1, 0.0, 1.01 * DECISION, False, id="too late"),
        pytest.param(False, 1, 0.9 * OLDEST, 0.9 * DECISION, False, id="as odometry has become too old"),
    ],
)
def test_what_is_commanded_is_executed_unless(fault, life, aged, taken, moves):
    base, wheels, now = Ros2Base(PAIR, 1, PAIR.base_of(1)), Wheels(PAIR, 1, Random(1)), 0.0
    odometry, pose = base.topics
    while now < 1.0:
        now += 0.02
        base.on_message(odometry, wheels.odometry(now).serialize(), now)
        base.on_message(pose, wheels.pose(now).serialize(), now)
        base.on_timer(now)
    for tick in (0, 1):  # by the second the coordinator has the Command of the first
        lived, heard = (life, 0) if tick else (1, None)
        base.begin(Tick(1, lived, tick, (1, 2), heard=heard), now + aged)
        for by in (0.5, 0.0) if fault and tick else ():
            base.on_message(odometry, shifted(wheels.odometry(now + 0.01), by).serialize(), now)
        told = decode(Velocity, base.obey(Command(1, lived, tick, (0.1, 0.1)), now + aged + taken))
    assert (told.linear[0] != 0.0 or told.angular[2] != 0.0) is moves


def test_the_same_message_twice_is_the_same_message():
    odometer, message = Odometer(Base(), PAIR.body_of(1)), Wheels(PAIR, 1, Random(1)).odometry(1.0)
    assert odometer.take(message, 0.0) == odometer.take(message, 0.1) == ""
    assert replace(PAIR, name="x").base_of(1) == Base()


@pytest.mark.parametrize("offset", [0.05, 0.2])  # m: a wheel is the fastest point, or the control point is
@pytest.mark.parametrize(("share", "fault"), [(0.98, False), (1.4, True)])
@pytest.mark.parametrize("way", ["jumps", "turns"])
def test_more_than_a_base_can_do_is_a_fault(way, share, fault, offset):
    body, passed = replace(PAIR.body_of(1), offset=offset), 0.2
    step = share * Kinematics(body, 0.1).top_speed * passed if way == "jumps" else 0.0
    angle = share * 2.0 * body.speed / body.track * passed if way == "turns" else 0.0
    odometer = Odometer(Base(), body)
    assert odometer.take(odometry(0.0, 0.0), 0.0) == ""
    after = replace_pose(odometry(passed, step), orientation=turn(angle))
    assert bool(odometer.take(after, passed)) is fault
    assert (odometer.newest.stamp == 0.0) is fault


def test_odometry_is_of_the_control_point_and_interpolated():
    body = PAIR.body_of(1)
    odometer, places = Odometer(Base(), body), []
    for stamp, x, y, yaw in ((0.0, 1.0, 2.0, 3.1), (0.1, 1.01, 2.01, 3.2), (0.2, 1.02, 2.01, 3.0)):
        message = replace_pose(odometry(stamp, 0.0), position=[x, y, 0.0], orientation=turn(yaw))
        assert odometer.take(message, stamp) == ""
        places.append((x + body.offset * math.cos(yaw), y + body.offset * math.sin(yaw), yaw))
    way = math.dist(places[0][:2], places[1][:2])
    between = [0.75 * before + 0.25 * after for before, after in zip(places[1], places[2], strict=True)]
    way += 0.25 * math.dist(places[1][:2], places[2][:2])
    assert odometer.at(0.125) == pytest.approx((0.125, *between, way))
    assert odometer.at(0.2) == odometer.newest
    assert (odometer.at(-0.1), odometer.at(0.3)) == (None, None)


def test_the_spread_of_odometry_is_its_share_of_the_true_way_and_its_drift():
    body = replace(PAIR.body_of(1), odometry=0.1, drift=0.002)
    assert Odometer(Base(), body).spread(0.9 * 2.0 - 0.002) == pytest.approx(0.1 * 2.0 + 0.002)


def test_odometry_drifts_in_every_tick_between_two_that_are_begun():
    senses, wheels, base = Senses(PAIR, 1, Base()), Wheels(PAIR, 1, Random(1)), Base()
    for step in range(1, 81):
        now = 0.02 * step
        senses.on_odometry(wheels.odometry(now).serialize(), now)
        senses.on_pose(wheels.pose(now).serialize())
        senses.look(now)
        if step == 50:
            assert senses.read(0, None, now) is not None
    sense = senses.read(6, None, now)
    assert sense is not None
    assert sense.displacement_bound == pytest.approx(6.0 * Odometer(base, PAIR.body_of(1)).spread(0.0))


@pytest.mark.parametrize("seed", range(6))
def test_the_truth_is_within_the_bounds_of_place_and_motion(seed):
    """Also after seconds without a pose, in an odometry frame that is askew in the map."""
    senses, wheels, before = Senses(PAIR, 1, PAIR.base_of(1)), Wheels(PAIR, 1, Random(seed)), None
    heading = PAIR.sensing_of(1).heading
    for step in range(2400):
        now, wheels.heard = 0.005 * step, 0.005 * step
        if now > 1.0:
            wheels.aims = (0.15, 0.17)
        wheels.roll(now)
        if step % 4 == 0:
            senses.on_odometry(wheels.odometry(now).serialize(), now)
        if step % 8 == 0 and now < 2.0:
            senses.on_pose(wheels.pose(now).serialize())
        senses.look(now)
        if step % 20 or (sense := senses.read(step // 20, None, now)) is None:
            continue
        (place, bound), truth = senses.place(), wheels.control
        assert math.dist(place, truth) <= bound < 0.3
        assert sense.stamp == step // 20
        assert sense.position is None or (sense.position, sense.bound) == (place, bound)
        assert abs(wrapped(senses.heading() - wheels.yaw)) <= heading + 1e-9
        if before is not None:
            moved = truth[0] - before[0], truth[1] - before[1]
            assert math.dist(sense.displacement, moved) <= sense.displacement_bound < 0.01
        before = truth
    assert before is not None
    assert senses.fault == ""
