"""Types of arrays."""

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
Complexes = NDArray[np.complex128]  # points of the plane, x + iy, m
