"""Every rule of the safety protocol, and the product without it: what a source would read if nobody had
thought of the rule. The models have to find a violation in each (`test_mutants`).
"""

from __future__ import annotations

from typing import NamedTuple

from tests.agents.lines.models import aftermath, skirmish, walk
from tests.agents.lines.models.product import LARGE_ROOM, Product
from tests.agents.lines.models.small_model import Bounds, search
from tests.interpreted import Edit

_PAIR, _BOND, _DISK, _LEDGER, _BOUNDARY = (
    f"agents.lines.{name}" for name in ("ends", "robot_pair", "tangent", "separating_lines", "boundary")
)
_THINGS, _OWN_SET, _INITIAL, _NEAR, _FAR, _LINE, _PLACEMENT = (
    f"agents.lines.{name}"
    for name in (
        "things",
        "own_set",
        "initial_lines",
        "negotiation.near",
        "negotiation.far",
        "line",
        "placement",
    )
)
_ROSTER, _ROBOT, _ESTIMATE, _FILTER, _RECKONING = (
    f"agents.{name}"
    for name in ("peers.roster", "robot", "localisation.estimate", "safety_filter", "localisation.reckoning")
)
_ROLL, _COMMANDS, _LIVES, _COORDINATOR, _BODIES = (
    "world.coordinator.roster",
    "world.coordinator.commands",
    "world.coordinator.lives",
    "world.coordinator.coordinator",
    "world.plants.integrator",
)
_RUNS = 2_000  # random ones in which a mutant has to be found, at most, wherever they begin


class Mutant(NamedTuple):
    """The product without one rule.

    Attributes:
        rule: its short name.
        says: the rule.
        edits: what reads otherwise without it.
        saved: False: the coordinator tells what it decided before it writes it down.
        model: that finds a violation; "walk", "skirmish" and "aftermath" are random, "pair" is exhaustive
            within `bounds`.
        first: the random run to begin with, where it takes many to come to one that shows the mutant.
    """

    rule: str
    says: str
    edits: tuple[Edit, ...] = ()
    saved: bool = True
    model: str = "walk"
    bounds: Bounds = Bounds()
    first: int = 0


class Found(NamedTuple):
    """A violation, and after how many runs or states; none if it is ""."""

    tried: int
    violation: str


def hunt(mutant: Mutant, first: int | None = None, runs: int = _RUNS) -> Found:
    """Look for what goes wrong without the rule, in random runs from `first` on, or the mutant's own."""
    product = Product(mutant.edits)
    if mutant.model == "pair":
        return Found(*search(mutant.bounds, product, mutant.saved))
    begin = mutant.first if first is None else first
    for tried, seed in enumerate(range(begin, begin + runs), 1):
        if mutant.model == "walk":
            violation = walk.violation_of(seed, product, mutant.saved)
        elif mutant.model == "skirmish":
            violation = skirmish.violation_of(seed, product)
        else:
            violation = aftermath.violation_of(seed, product)
        if violation:
            return Found(tried, violation)
    return Found(runs, "")


PAIR = (
    Mutant(
        "propose-satisfied",
        "an owner proposes only a line that its own disk satisfies now",
        (Edit(_NEAR, "if line is None or not fits(line):", "if line is None:"),),
    ),
    Mutant(
        "obey-at-once",
        "an owner obeys a proposal from the moment when it makes it",
        (
            Edit(
                _PAIR,
                "return (*self._inherited, *held, *self.proposed.values())",
                "return (*self._inherited, *held)",
            ),
        ),
    ),
    Mutant(
        "obey-both",
        "until there is an answer it obeys what it held, too",
        (Edit(_PAIR, "        self.number += 1\n", "        self.number += 1\n        self.held = None\n"),),
    ),
    Mutant(
        "drop-on-answer",
        "it drops a proposal only when an answer says that this number has been answered",
        (
            Edit(
                _PAIR,
                "for number, line in self.proposed.items() if number > seen}",
                "for number, line in ()}",
            ),
        ),
    ),
    Mutant(
        "hold-what-is-held",
        "of the lines that were answered it goes on obeying the one that the follower holds",
        (Edit(_PAIR, "if held in self.proposed:", "if seen in self.proposed:\n            held = seen"),),
    ),
    Mutant(
        "adopt-satisfied",
        "a follower adopts only a line that its own disk satisfies now",
        (Edit(_PAIR, "if not fits(line):", "if False:"),),
    ),
    Mutant(
        "answer-once",
        "a number that was answered, or passed over, is never adopted later",
        (Edit(_PAIR, "or number <= self.seen:\n", "or number == self.held_number:\n"),),
    ),
    Mutant(
        "reject-for-ever",
        "a number that was rejected is never adopted later, though the own disk may satisfy it then",
        (Edit(_PAIR, "or number <= self.seen:\n", "or number <= self.held_number:\n"),),
    ),
    Mutant(
        "no-line-no-motion",
        "a robot moves only while every peer that is there is behind a line or a tangent",
        (Edit(_LEDGER, "if not (pair.settled or pair.ready):", "if False:"),),
    ),
)


LIVES = (
    Mutant(
        "answer-to-this-life",
        "an answer counts only for the life of the owner that it names",
        (
            Edit(
                _PAIR,
                "            or incarnation != self.incarnation\n            or not self.seen",
                "            or not self.seen",
            ),
        ),
    ),
    Mutant(
        "offer-to-this-life",
        "a proposal counts only for the life of the follower that it names",
        (
            Edit(
                _PAIR, "or incarnation != self.incarnation or number <= self.seen:", "or number <= self.seen:"
            ),
        ),
        first=1422,
    ),
    Mutant(
        "older-follower-ignored",
        "an owner ignores lives of the follower that are older than the newest known",
        (
            Edit(
                _PAIR,
                "            not self.accept(peer_incarnation)\n            or incarnation",
                "            incarnation",
            ),
            Edit(
                _BOND,
                "            if not self.end.accept(state.incarnation):\n                return False\n",
                "            self.end.accept(state.incarnation)\n",
            ),
        ),
    ),
    Mutant(
        "older-owner-ignored",
        "a follower ignores lives of the owner that are older than the newest known",
        (
            Edit(
                _PAIR,
                "if not self.accept(peer_incarnation) or incarnation != self.incarnation or number",
                "if incarnation != self.incarnation or number",
            ),
            Edit(
                _BOND,
                "            if not self.end.accept(state.incarnation):\n                return False\n",
                "            self.end.accept(state.incarnation)\n",
            ),
        ),
    ),
    Mutant(
        "rosters-name-lives",
        "either end ignores lives of the other that are older than the one that a roster names",
        (Edit(_BOND, "if incarnation > self.end.peer_incarnation:", "if False:"),),
        model="pair",
        bounds=Bounds((2, 1), proposals=1, founding=(1,), versions=4, talks_on=True),
    ),
    Mutant(
        "first-roster-names-lives",
        "so it is with the first roster that a life hears",
        (Edit(_LEDGER, 'if member.status != "live" or not founding:', 'if member.status != "live":'),),
        model="pair",
        bounds=Bounds((1, 2), proposals=1, founding=(2,), versions=4, talks_on=True),
    ),
    Mutant(
        "lives-are-ordered",
        "which of two lives is the newer one follows from their numbers, not from who was heard last",
        (
            Edit(
                _PAIR,
                "        if peer_incarnation > self.peer_incarnation:\n            self.linked",
                "        if peer_incarnation != self.peer_incarnation:\n            self.linked",
            ),
        ),
    ),
    Mutant(
        "numbers-begin-anew",
        "a follower counts the numbers of each life of the owner by themselves",
        (Edit(_PAIR, "            self.held_number = self.seen = 0\n", ""),),
    ),
    Mutant(
        "inherit-held",
        "an owner whose follower lives anew goes on obeying the line that was held",
        (
            Edit(
                _PAIR, "self._inherited = self.obeyed\n", "self._inherited = tuple(self.proposed.values())\n"
            ),
        ),
    ),
    Mutant(
        "inherit-proposed",
        "and every unanswered proposal: it may have been adopted in the moment of death",
        (Edit(_PAIR, "self._inherited = self.obeyed\n", "self._inherited = self.obeyed[:1]\n"),),
    ),
    Mutant(
        "unadopted-count-for-nothing",
        "a proposal that no life is known to have adopted is no line: the peer may have moved past it",
        (
            Edit(
                _PAIR,
                "        self.proposed[self.number] = line\n",
                "        self.proposed[self.number] = line\n        self.agreed = True\n",
            ),
        ),
    ),
    Mutant(
        "offer-to-who-was-heard",
        "nothing is offered to a life that has not been heard",
        (
            Edit(_NEAR, "if not end.met or len(end.proposed)", "if len(end.proposed)"),
            Edit(
                _NEAR,
                "        if state is None or not state.placed:\n            return 0\n",
                "        if state is None:\n"
                "            state = PeerState(pair.peer, 0, 0, True, 0.0, float(pair.peer), 0.0, 0.0, "
                "0.0, 0.0, 0.0, radius=0.0)\n",
            ),
        ),
        model="pair",
        bounds=Bounds((1, 1), proposals=1, founding=(1,), removals=1, appearances=1),
    ),
    Mutant(
        "dead-lines-are-kept",
        "a follower whose owner lives anew goes on obeying the line that it holds",
        (
            Edit(
                _PAIR,
                "            self.held_number = self.seen = 0\n",
                "            self.held_number = self.seen = 0\n            self._held = None\n",
            ),
            Edit(
                _PAIR,
                "        return self._held is not None\n\n    @property\n    def settled",
                "        return True\n\n    @property\n    def settled",
            ),
        ),
    ),
)


WHO_IS_THERE = (
    Mutant(
        "founding-only",
        "only a life that began the run knows the initial lines",
        (Edit(_ROSTER, "own.founding == self._incarnation > 0", "own.founding > 0"),),
    ),
    Mutant(
        "late-lives-are-newcomers",
        "whoever was not there when the run began is no founding life when it comes",
        (
            Edit(
                _ROLL,
                'self._put(replace(member, incarnation=incarnation, status="live", position=None, '
                "bound=0.0))",
                'self._put(replace(member, incarnation=incarnation, status="live", position=None, '
                "bound=0.0, founding=member.founding or incarnation))",
            ),
        ),
    ),
    Mutant(
        "newer-lives-only",
        "only a life with a new number is admitted",
        (Edit(_ROLL, "if incarnation <= member.incarnation:", "if False:"),),
    ),
    Mutant(
        "acknowledge-before-appearing",
        "a disk appears only after every live robot has acknowledged the version that announces it",
        (Edit(_ROLL, "                and self.all_keep_clear()\n", ""),),
    ),
    Mutant(
        "admission-is-no-acknowledgement",
        "to be admitted with that version is no acknowledgement: the life may begin on the place",
        (
            Edit(
                _ROLL,
                "position=None, bound=0.0))\n\n    def fence",
                "position=None, bound=0.0))\n"
                "        self._kept[robot] = (incarnation, self.version)\n"
                "\n"
                "    def fence",
            ),
        ),
    ),
    Mutant(
        "acknowledge-the-newest",
        "an acknowledgement of an earlier version is none of this one",
        (
            Edit(
                _ROLL,
                "            self._kept.get(each.robot) == (each.incarnation, self.version)\n            for",
                "            self._kept.get(each.robot, (0, 0))[0] == each.incarnation\n            for",
            ),
        ),
    ),
    Mutant(
        "acknowledge-when-clear",
        "a robot acknowledges only what it keeps clear of, by a tangent",
        (Edit(_LEDGER, "return not self._disturbed or all(", "return True or all("),),
    ),
    Mutant(
        "appear-where-nothing-stands",
        "a disk appears only where no disk stands",
        (Edit(_ROLL, " and self._is_free(member)", ""),),
    ),
    Mutant(
        "appear-as-standing",
        "what has appeared stands, for whoever is admitted later",
        (
            Edit(
                _ROLL,
                'self._put(replace(member, status="standing"))',
                'self._put(replace(member, status="appearing", position=(9.0, 9.0)))',
            ),
        ),
    ),
    Mutant(
        "gone-after-fenced",
        "only what stands can be struck off",
        (
            Edit(
                _ROLL,
                '        if member.status != "standing":\n'
                '            raise RosterError(f"robot {robot} cannot be removed',
                '        if False:\n            raise RosterError(f"robot {robot} cannot be removed',
            ),
        ),
    ),
    Mutant(
        "older-versions-ignored",
        "a robot never follows a version older than one that it knows",
        (Edit(_ROSTER, "if roster.version <= self.version:", "if roster.version == self.version:"),),
    ),
    Mutant(
        "heard-life-is-not-excused",
        "a version that is older than a life already heard excuses nobody",
        (Edit(_BOND, "if member.incarnation < self.heard:", "if False:"),),
        model="pair",
        bounds=Bounds(lives=(1, 2), proposals=1, fences=1),
    ),
    Mutant(
        "standing-is-there",
        "a standing disk is behind a tangent, or the robot stands still",
        (Edit(_BOND, 'self.excused = member.status == "appearing"', "self.excused = True"),),
    ),
    Mutant(
        "tangent-when-clear",
        "a tangent is taken only if the own disk satisfies it",
        (Edit(_DISK, "if own.satisfies(tangent):", "if True:"),),
    ),
    Mutant(
        "standing-behind-the-line",
        "a line stays in the place of the tangent only if the disk stands behind it",
        (Edit(_DISK, "if shape.limit(side.nx, side.ny, own_radius) >= side.limit:", "if True:"),),
    ),
    Mutant(
        "line-replaces-standing-when-agreed",
        "a standing place counts until a line with the new life is agreed",
        (
            Edit(
                _BOND,
                "        if self.end.agreed:\n            self.disk = None\n",
                "        if self.end.obeyed:\n            self.disk = None\n",
            ),
            Edit(
                _BOND,
                "return self.excused or self.end.agreed or self.keeps_clear",
                "return self.excused or bool(self.end.obeyed) or self.keeps_clear",
            ),
        ),
    ),
    Mutant(
        "standing-life-is-over",
        "of a life that stands nothing counts any more, whatever it says",
        (Edit(_BOND, "        self.end.fence(incarnation)\n", "        self.end.fence(incarnation - 1)\n"),),
    ),
    Mutant(
        "save-before-telling",
        "the coordinator writes down what it decided before it tells anybody",
        saved=False,
    ),
)


ITSELF = (
    Mutant(
        "settled-commands",
        "lines are taken over only while no command is under way",
        (Edit(_ROBOT, "if self._open and tick <= self.tick and self._link.ideal", "if self._link.ideal"),),
        model="skirmish",
        first=340,
    ),
    Mutant(
        "own-error-at-lines",
        "every place where the own centre can be keeps to the lines, not the most likely one",
        (
            Edit(
                _OWN_SET,
                "return self.bound if self.shape is None else self.shape.extent(nx, ny)",
                "return 0.0",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "own-error-at-the-wall",
        "and to the wall",
        (
            Edit(
                _BOUNDARY,
                "if math.hypot(x + dx, y + dy) + shape.radius + extra <= rim:",
                "if math.hypot(x + dx, y + dy) + extra <= rim:",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "actuation-error",
        "a command leaves room for the stated error of its execution",
        (Edit("agents.bodies.point", "noise=self._noise,", "noise=0.0,"),),
        model="skirmish",
    ),
    Mutant(
        "missed-odometry",
        "a tick whose odometry was missed may have led as far as any",
        (
            Edit(_ESTIMATE, "self._widen(self._max_step)", "pass"),
            Edit(
                _ESTIMATE,
                "self._history.append(Move(0.0, 0.0, self._max_step))",
                "self._history.append(Move(0.0, 0.0, 0.0))",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "measured-then",
        "a measurement is of the tick that its stamp names",
        (Edit(_ESTIMATE, "for back in range(-age, 0):", "for back in ():"),),
        model="skirmish",
    ),
    Mutant(
        "command-of-this-tick",
        "a command counts only in the tick that it names",
        (Edit(_COMMANDS, "if command.tick != self._tick or not self._open:", "if not self._open:"),),
        model="skirmish",
    ),
    Mutant(
        "watchdog",
        "a robot whose command is missing stands still",
        (
            Edit(
                _BODIES,
                "            velocity = commands.get(robot)\n",
                "            velocity = self.last[robot] = commands.get(robot, self.last.get(robot))\n",
            ),
            Edit(
                _BODIES,
                "        self._actuation = Actuation(scenario)\n",
                "        self._actuation = Actuation(scenario)\n        self.last: dict[int, Vector] = {}\n",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "fenced-never-moves",
        "no command of a life is executed after it was announced as standing",
        (
            Edit(_COMMANDS, '        if life.fenced:\n            return "fenced"\n', ""),
            Edit(
                _LIVES,
                "            if life.status is Status.UP:\n"
                "                life.status = Status.LOST\n"
                "\n"
                "    def listeners",
                "\n    def listeners",
            ),
            Edit(
                _ROSTER,
                'return member.incarnation > incarnation or member.status != "live"',
                "return member.incarnation > incarnation",
            ),
        ),
        model="skirmish",
    ),
)


SURROUNDINGS = (
    Mutant(
        "things-before-moving",
        "a robot moves only while it is behind a tangent to everything that stands",
        (
            Edit(
                _FILTER,
                "return self.lines.ready and self.things.ready",
                "return self.lines.ready",
            ),
        ),
        model="skirmish",
        first=435,
    ),
    Mutant(
        "start-of-founders",
        "only a founding life knows that its disk is where the scenario lets it begin",
        (Edit(_FILTER, "starts[robot] if founding else None", "starts[robot]"),),
        model="skirmish",
        first=207,
    ),
    Mutant(
        "own-error-at-things",
        "every place where the own centre can be keeps clear of things",
        (Edit(_THINGS, "found.append(own.kept_in(side.nx, side.ny, side.limit))", "found.append(side)"),),
        model="skirmish",
    ),
    Mutant(
        "own-error-at-straight-walls",
        "and of straight walls",
        (Edit(_BOUNDARY, "wall.slack(x, y) - extent - 2.0 * ROUNDING", "wall.slack(x, y)"),),
        model="skirmish",
    ),
    Mutant(
        "acknowledge-things-when-clear",
        "a version that announces a thing is acknowledged only by who is clear of its place",
        (
            Edit(
                _FILTER,
                "(self.lines.keeps_clear and self.things.keeps_clear)",
                "self.lines.keeps_clear",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "things-appear-when-acknowledged",
        "a thing is put up only when everybody live has acknowledged its place",
        (
            Edit(
                _LIVES,
                "if not self.things.appearing or not self._roster.all_keep_clear():",
                "if not self.things.appearing:",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "things-appear-beside-standing-disks",
        "and not where the disk of a life that is over stands",
        (Edit(_LIVES, "settled = self.things.settle(disks)", "settled = self.things.settle([])"),),
        model="skirmish",
    ),
    Mutant(
        "nearest-point",
        "a tangent touches the thing itself: one through its middle leaves half of it on the own side",
        (
            Edit(
                _DISK,
                "HalfPlane(nx, ny, target.limit(nx, ny, self.radius))",
                "HalfPlane(nx, ny, nx * around.x + ny * around.y - self.radius)",
            ),
        ),
        model="skirmish",
    ),
)


FAR = (
    Mutant(
        "offer-before-moving",
        "a letter is written before the velocity is chosen, which keeps to what it offers",
        (
            Edit(_ROBOT, "            letter = self._letter(filter_)  #", "            #"),
            Edit(
                _ROBOT,
                "(), report, letter, handles",
                "(), report, None if filter_ is None else self._letter(filter_), handles",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "look-at-initial-lines",
        "an initial line counts although nobody has spoken of it",
        (Edit(_INITIAL, "return self.within(x, y, self._looked)", "return []"),),
        model="skirmish",
    ),
    Mutant(
        "look-again",
        "who has moved looks again at those that were out of reach",
        (
            Edit(_LEDGER, "AHEAD: Final = 20.0", "AHEAD: Final = 0.0"),
            Edit(_INITIAL, "+ reach <= self._looked:", "* 0.0 <= self._looked:"),
        ),
        model="skirmish",
        first=54,
    ),
    Mutant(
        "rest-out-of-reach",
        "a line rests only where the own disk is farther off than it has looked",
        (
            Edit(
                _INITIAL,
                "if side.slack(self._looked_x, self._looked_y) < self._looked + _ROUNDING:",
                "if False:",
            ),
        ),
        model="skirmish",
    ),
    Mutant(
        "wake",
        "a line that rested is looked at by itself again as soon as somebody may be near, or speaks of it",
        (*LARGE_ROOM, Edit(_LEDGER, "if pair is not None and not pair.rests:", "if pair is not None:")),
        model="skirmish",
    ),
    Mutant(
        "silence-is-no-news",
        "whoever is told nothing of how its robot went knows nothing of it: the command may have been void",
        (
            Edit(_COORDINATOR, "for robot in awaited if of[robot].fenced]", "for robot in awaited if of]"),
            Edit(_RECKONING, "if went_as_commanded and self._place", "if told is None and self._place"),
        ),
        model="aftermath",
        first=191,
    ),
)


AFTERWARDS = (
    Mutant(
        "answer-who-lives-again",
        "a far peer that stood and has spoken since is answered, though its disk is kept clear of until then",
        (Edit(_FAR, " and pair.heard < end.peer_incarnation:", ":"),),
        model="aftermath",
    ),
    Mutant(
        "halfway",
        "two that begin anew as near as they may come to stand can agree on a line",
        (Edit(_PLACEMENT, "return _halfway(span, owner.radius, follower.radius)", "return None"),),
        model="aftermath",
    ),
    Mutant(
        "sure",
        "for they need less room for that than they leave when they move",
        (Edit(_LINE, "0.25 * ROUNDING", "ROUNDING"),),
        model="aftermath",
    ),
)


MUTANTS = (*PAIR, *LIVES, *WHO_IS_THERE, *ITSELF, *SURROUNDINGS, *FAR, *AFTERWARDS)
