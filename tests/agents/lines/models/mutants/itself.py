"""What a robot knows of itself: where it is, and what it commands."""

from __future__ import annotations

from tests.agents.lines.models.mutants.mutant import Mutant
from tests.interpreted import Edit

_BODIES = "world.plants.integrator"
_BOUNDARY = "agents.lines.boundary"
_COMMANDS = "world.coordinator.commands"
_ESTIMATE = "agents.estimate"
_LIVES = "world.coordinator.lives"
_OWN_SET = "agents.lines.own_set"
_HEARING = "agents.hearing"
_ROSTER = "agents.peers.roster"

ITSELF = (
    Mutant(
        "settled-commands",
        "lines are taken over only while no command is under way",
        (Edit(_HEARING, "if self._open and tick <= self._tick and self._link.ideal", "if self._link.ideal"),),
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
        (Edit("agents.bodies", "noise=self._noise,", "noise=0.0,"),),
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
