"""Renews the kept trajectories, and says by how much each has changed: `make golden`.

A change of the control, the sensors or the world moves trajectories. Commit the new ones together with
the change that moves them, and say in its message why they move.
"""

from tests.golden import kept
from tests.golden.cases import CASES, SADDLES
from tests.golden.trajectory import Trajectory, run


def change(case: str, before: Trajectory | None, after: Trajectory) -> str:
    """In words, how one trajectory differs from what was kept."""
    if before is None:
        return "new"
    if before.sha256 == after.sha256:
        return "the same to the last bit"
    if case in SADDLES:
        return "other bits"
    moved = f"moved by up to {1e3 * before.deviation(after):.3f} mm"
    return moved if before.ticks == after.ticks else f"{moved}; {before.ticks} ticks, now {after.ticks}"


def main() -> None:
    before = kept.read()
    after = {case: run(build()) for case, build in CASES.items()}
    for case, trajectory in after.items():
        print(f"{case:<30} {change(case, before.get(case), trajectory)}")
    for case in before.keys() - after.keys():
        print(f"{case:<30} no longer kept")
    kept.write(after)


if __name__ == "__main__":
    main()
