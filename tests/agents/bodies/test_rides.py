"""Bodies keep to what they must obey, whatever commands are lost; the product without one of its rules is
found to leave it. Two mutants look right at first, and are off by little: without the hold time, and without
the way to the place where the body stands."""

import pytest

from tests.agents.bodies.ride import KINDS, Product, Ride, violation_of
from tests.interpreted import Edit, Mutant, without

pytestmark = pytest.mark.slow

RIDES = 2  # the campaign `bodies` goes on
_KINEMATICS, _SWEEP, _INERTIAL, _OWN_SET = (
    "protocol.bodies.kinematics",
    "protocol.bodies.sweep",
    "agents.bodies",
    "agents.lines.own_set",
)
_RIDES = 400  # in which a mutant has to be found, at most
_PERIOD = 0.1  # s, at which all of them are found soon

MUTANTS = (
    without(
        "hold",
        "a base that hears nothing goes on for its hold time before it brakes",
        Edit(
            _KINEMATICS,
            "return Arc(motion.ahead, motion.aside, motion.hold + 0.5 * self._stopping(motion))",
            "return Arc(motion.ahead, motion.aside, 0.5 * self._stopping(motion))",
        ),
        model="omnidirectional",
    ),
    without(
        "brake",
        "and then goes on until it stands",
        Edit(
            _KINEMATICS,
            "return Arc(motion.ahead, motion.aside, motion.hold + 0.5 * self._stopping(motion))",
            "return Arc(motion.ahead, motion.aside, motion.hold)",
        ),
        model="omnidirectional",
    ),
    without(
        "finish-braking",
        "the whole way to where it stands is allowed, not only that place",
        Edit(_SWEEP, "for index, x in enumerate(self.xs):", "for index, x in list(enumerate(self.xs))[-1:]:"),
        model="omnidirectional",
    ),
    without(
        "adopt-swept",
        "a line is adopted only if it allows everything that follows from the commands that are out",
        Edit(_OWN_SET, "extent += self.swept.extent(nx, ny)", "pass"),
        model="omnidirectional",
    ),
    without(
        "reachable",
        "what is commanded is what the base can reach in a tick",
        Edit(
            _INERTIAL,
            "self._tolerance, kinematics.limited(motion, command))",
            "self._tolerance, turned(*command, -motion.heading))",
        ),
        Edit(
            _INERTIAL,
            "        ahead, aside = self._kinematics.limited(self._motion, velocity)\n",
            "        ahead, aside = turned(*velocity, -self._motion.heading)\n",
        ),
        Edit(_INERTIAL, "import Kinematics, Motion\n", "import Kinematics, Motion, turned\n"),
        model="omnidirectional",
    ),
    without(
        "one-factor",
        "braking scales both wheels by one factor; each by itself would leave the circle",
        Edit(
            _KINEMATICS,
            "        return Motion(heading, motion.ahead * left, motion.aside * left, 0.0)\n",
            "        across = motion.aside * self._half_track / self._offset\n"
            "        slower = self._acceleration * rest\n"
            "        pair = [math.copysign(max(0.0, abs(each) - slower), each)\n"
            "                for each in (motion.ahead - across, motion.ahead + across)]\n"
            "        across = 0.5 * (pair[1] - pair[0]) * self._offset / self._half_track\n"
            "        return Motion(heading, 0.5 * (pair[0] + pair[1]), across, 0.0)\n",
        ),
        model="differential-drive",
    ),
    without(
        "arcs",
        "a body that turns describes arcs",
        Edit(_SWEEP, "        turn = kinematics.turn(piece)\n", "        turn = 0.0\n"),
        model="differential-drive",
    ),
    without(
        "turning",
        "where a body that turns by more than half a circle will stand does not say how far it goes",
        Edit(_KINEMATICS, "0.5 * self._stopping(still)) > _TURNING:", "0.5 * self._stopping(still)) > 1e9:"),
        model="spinning",
    ),
    without(
        "error",
        "a base misses what it is told by a share of its way",
        Edit(_SWEEP, "_Hull(error, slip)", "_Hull(0.0, slip)"),
        model="omnidirectional",
    ),
    without(
        "slip",
        "and by its lag and play",
        Edit(_SWEEP, "_Hull(error, slip)", "_Hull(error, 0.0)"),
        model="omnidirectional",
    ),
    without(
        "change",
        "lag counts for the velocity that it had, even if the one commanded is small",
        Edit(_SWEEP, "tolerance.slip(motion, to)\n", "tolerance.slip(Motion(0.0), to)\n"),
        model="omnidirectional",
    ),
    without(
        "heading",
        "a base that takes itself to face elsewhere goes elsewhere",
        Edit(_SWEEP, "2.0 * math.sin(0.5 * heading)", "0.0 * heading"),
        model="differential-drive",
    ),
    without(
        "sides-tested",
        "a velocity is commanded only if all that follows from it keeps to every line",
        Edit(_INERTIAL, "            if excess > 0.0:", "            if excess > 9.0:"),
        model="differential-drive",
    ),
    without(
        "boundary-tested",
        "and inside the workspace",
        Edit(_INERTIAL, "            if fits and cut is None:", "            if fits:"),
        model="differential-drive",
    ),
)


@pytest.mark.parametrize("kind", KINDS)
def test_a_body_never_leaves_what_it_must_obey(kind: str) -> None:
    product = Product()
    for seed in range(RIDES):
        assert violation_of(seed, kind, product) == "", f"seed {seed}"


@pytest.mark.parametrize("kind", KINDS)
def test_and_does_not_keep_to_it_by_standing(kind: str) -> None:
    """Of the way that it would go if nothing were in the way, some share; standing would give none."""
    product, way, most = Product(), 0.0, 0.0
    for seed in range(10):  # of fewer, some hardly have room to go anywhere
        ride = Ride(seed, kind, product, period=0.1)
        for _ in range(60):
            x, y = ride.x, ride.y
            ride.tick()
            way += abs(complex(ride.x - x, ride.y - y))
            most += ride.speed * ride.period
    assert way > 0.03 * most


@pytest.mark.campaign
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.rule)
def test_without_a_rule_it_does(mutant: Mutant) -> None:
    product = Product(mutant.edits)
    assert mutant.hunt(lambda seed: violation_of(seed, mutant.model, product, period=_PERIOD), _RIDES)
