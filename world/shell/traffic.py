"""Messages of a whole run: what robots and world counted, summed up."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from protocol.messages import Health


def traffic(
    reports: Iterable[Health | None], published: int, received: int, rejected: Counter[str]
) -> dict[str, object]:
    """`published` and `received` (accepted) messages and those rejected by reason, over all processes.

    Args:
        reports: last words of the robots that gave any.
        published, received, rejected: the world's own counts.
    """
    total = Counter(rejected)
    for health in reports:
        if health is not None:
            published += health.published
            received += health.received
            total.update(health.rejected)
    return {"published": published, "received": received, "rejected": dict(sorted(total.items()))}
