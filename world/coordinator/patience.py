"""Which robots are given up when a lock-step tick does not end, so that one faulty process costs one robot.

When the tick is told again, a robot that cannot command names the States that it lacks. Given up are:

1. a robot that owes a command and is silent: it hangs, though its session lives;
2. one whose State more than half of its receivers lack: it sends none, or what all refuse;
3. if there is neither, one that cannot command: it does not receive what the others receive.

Half of all receivers, not of those that wait: one deaf robot must not have all others given up.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping

SILENT = "hangs: it does not answer"


def blamed(
    heard_by: Mapping[int, int], waiting: Collection[int], lacking: Mapping[int, Collection[int]]
) -> dict[int, str]:
    """Robots to give up, with reasons, in a tick that was told again; at least one, if any is waited for.

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
