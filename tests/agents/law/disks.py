"""Random disks that do not overlap."""

import numpy as np


def scattered(rng: np.random.Generator, n: int, radius: float, workspace: float) -> np.ndarray:
    while True:
        placed: list[np.ndarray] = []
        for _ in range(200 * n):
            spot = rng.uniform(-workspace, workspace, 2)
            if np.hypot(*spot) < workspace - radius - 0.002 and all(
                np.hypot(*(spot - other)) > 2 * radius + 0.002 for other in placed
            ):
                placed.append(spot)
            if len(placed) == n:
                return np.array(placed)
