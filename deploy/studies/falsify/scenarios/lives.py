"""Process faults: who is killed, frozen and started again, and in which ticks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

from deploy.studies.falsify.scenarios.dice import Dice
from protocol.scenario.checks.faults import EVENTS
from protocol.scenario.model import ProcessFault

Event = Literal["kill", "pause", "resume", "restart"]
Step = tuple[int, Event]  # ticks since the story began, and what happens then

# what is mentioned twice is told twice as often
_STORIES = (
    *("late", "late", "restart", "restart", "again", "again", "killed"),
    *("back", "back", "frozen", "frozen", "replaced"),
)


def stories(dice: Dice, robots: Sequence[int], ticks: int, step: float) -> tuple[ProcessFault, ...]:
    """None to several stories of single robots, in a run of so many ticks of `step` seconds.

    late: killed at tick 0, and up again later; restart; again: several restarts; killed: for good;
    back: killed, and up again later; frozen: paused and resumed; replaced: paused, then restarted.
    """
    faults: list[ProcessFault] = []
    for _ in range(dice.pick((0, 0, 1, 1, 2, 2, 3, 4, 6))):
        robot, kind = dice.pick(robots), dice.pick(_STORIES)
        begin = 0 if kind == "late" else moment(dice, ticks, step, faults)
        faults += [
            ProcessFault(robot, (begin + after) * step, event) for after, event in _told(dice, kind, ticks)
        ]
    return sensible(faults)


def _told(dice: Dice, kind: str, ticks: int) -> list[Step]:
    """What happens to one robot, from when its story begins."""
    later = dice.pick((1, 2, dice.whole(1, 10), dice.whole(1, max(1, ticks // 2))))
    match kind:
        case "late" | "back":
            return [(0, "kill"), (later, "restart")]
        case "restart":
            return [(0, "restart")]
        case "again":
            pause = dice.pick((1, 2, 5, later))
            return [(n * pause, "restart") for n in range(dice.whole(2, 4))]
        case "killed":
            return [(0, "kill")]
        case "frozen":
            return [(0, "pause"), (later, "resume")]
        case _:
            return [(0, "pause"), (later, "restart")]


def moment(dice: Dice, ticks: int, step: float, events: Sequence[ProcessFault]) -> int:
    """A tick for something to happen: at the very start, near something else, or anywhere."""
    choice = dice.whole(0, 3)
    if choice == 0:
        return dice.pick((0, 0, 1, 2, 3))
    if choice == 1 and events:
        return max(0, round(dice.pick(events).at / step) + dice.whole(-3, 3))
    return dice.whole(0, max(1, (3 * ticks) // 4))


def sensible(faults: Iterable[ProcessFault]) -> tuple[ProcessFault, ...]:
    """Faults in the order of their times, without those that cannot happen to a process in its state then."""
    state: dict[int, str] = {}
    kept = []
    for fault in sorted(faults, key=lambda fault: fault.at):
        following = EVENTS[state.get(fault.robot, "running")].get(fault.event)
        if following is not None:
            state[fault.robot] = following
            kept.append(fault)
    return tuple(kept)
