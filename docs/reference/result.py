"""The page of result fields. A test compares them with those of a run."""

from __future__ import annotations

FIELDS = {
    "scenario": "its name",
    "seed": "of everything random in the run",
    "run": "name of the run",
    "mode": "`lockstep` or `realtime`",
    "transport": "`routed`, `mesh` or `local`",
    "robots": "ids, ascending",
    "law": "`control.law`",
    "filter": "`control.filter`",
    "plant": "its `kind`; the first `contacts` that a physics engine found: `pair`, `tick`; of external "
    "bases `reported_bound`, m, by which a reported position was off at most, and everything here rests on "
    "those",
    "k": "the number in use",
    "verdict": "`collision` outranks `arrived`, `timeout`, `deadlock`, `interrupted` and `aborted`",
    "reason": "for the verdict, for people",
    "arrived": "ids of robots that are within the tolerance of their goals at the end",
    "collisions": "contact intervals between two disks, or a disk and the boundary or an obstacle",
    "contacts": "the first of them: `pair` (0: the boundary, -n: obstacle n), `from` and `until` (s), "
    "`deepest` overlap (m)",
    "min_clearance": "m, smallest gap between two disks, or a disk and the boundary or an obstacle, over "
    "continuous time; negative is overlap",
    "nrl": "lengths of all paths over all straight distances from start to goal; 1 is straight",
    "path_lengths": "m, by robot",
    "lateral_deviation": "m, by robot: largest distance from the segment between its start and its goal",
    "tight": "tightness of the goals, in the paper's centimetres",
    "ticks": "how many are over",
    "sim_time": "s of simulated time",
    "wall_time": "s of real time, from the first tick",
    "ticks_per_second": "ticks over wall time",
    "missed_commands": "how often a robot that took part had no command in time",
    "rejected_commands": "commands refused by the world, by reason",
    "down": "ids of robots whose disks stand at the end, without a life that moves them",
    "orders": "the scenario's `orders` that were due, each with its `tick` and the reason if `refused`",
    "faults": "what was injected: `process` faults, `fenced` lives, robots that the world has `given_up`, "
    "`measurements` (`delayed`, `missing`, `dropped`), and the scenario's `sensing`, `link` and `actuation`",
    "phi": "navigation function: `first`, `last`, and in how many ticks it rose (`increases`)",
    "log_potential": "log10(gamma^k / beta) / k, with which phi grows: `first` and `last`; -300 where "
    "all are at their goals, 300 in contact; unlike phi, it is not 1 to all digits in a large fleet",
    "positions": "m, by robot, at the end",
    "trajectory_sha256": "over all true positions: little-endian doubles in the order tick, robot, x, y; if "
    "the world died, from the last tick of `worlds` on",
    "worlds": "ticks with which another world went on after the one before it had died; all other fields are "
    "of the whole run, but for `messages` and `measurements`",
    "messages": "`published`, `received` by all processes together, `rejected` by reason",
    "processes": "one object a process: `name`, `pid`, `exit_code`, `restarts`, `cpu_s`, `max_rss_mb`; "
    "on several hosts `host`",
    "recordings": "files that were recorded to",
}


def page() -> str:
    """As Markdown."""
    lines = [
        "# Results",
        "",
        "The object that `disknav run --json FILE` writes, and `disknav.Run.result` holds: SI units; `null` "
        "where a measure has no meaning.",
        "",
        "| field | |",
        "|---|---|",
    ]
    return "\n".join([*lines, *(f"| `{name}` | {text} |" for name, text in FIELDS.items())]) + "\n"
