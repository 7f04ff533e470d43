"""Who is given up when a lock-step tick does not end, so that one sick process costs one robot.

When the tick is told again, whoever cannot command says whose States it lacks. Then it shows who is sick:

1. who owes a command and says nothing: it hangs, though its session lives;
2. whose State more than half of those lack who hear it: it sends none, or what everybody refuses;
3. if there is neither, whoever cannot command: it does not hear what the others hear.

Half of all those, not of those who wait: one that hears nobody must not have all others given up.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping

SILENT = "hangs: it does not answer"


def blamed(
    heard_by: Mapping[int, int], waiting: Collection[int], lacking: Mapping[int, Collection[int]]
) -> dict[int, str]:
    """Whom to give up, and why, in a tick that was told again; somebody, if anybody is waited for.

    Args:
        heard_by: how many hear each robot that takes part, itself included.
        waiting: those of them that owe a command.
        lacking: whose States each of these said that it lacks, since the tick was told again.
    """
    silent = {robot: SILENT for robot in sorted(waiting) if not lacking.get(robot)}
    lack = Counter(peer for robot in waiting for peer in set(lacking.get(robot, ())) if peer in heard_by)
    unheard = {
        robot: f"sends no State that its peers take: {count} of {heard_by[robot] - 1} lack it"
        for robot, count in sorted(lack.items())
        if 2 * count > heard_by[robot] - 1
    }
    return (unheard | silent) or {
        robot: f"does not hear its peers: it lacks the State of {_names(lacking[robot])}"
        for robot in sorted(waiting)
    }


def _names(robots: Collection[int]) -> str:
    shown = sorted(robots)[:3]
    more = len(robots) - len(shown)
    return f"robot {', '.join(map(str, shown))}" + (f" and {more} more" if more else "")
