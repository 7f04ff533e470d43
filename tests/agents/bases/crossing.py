"""Three robots: the straight ways of two lead through each other, and that of the third through one of them.

The third crosses where the first has left: planners that heed no robot would never leave a ring of three that
block each other.
"""

WAYS = (((-0.6, 0.0), (0.6, 0.1), 0.0), ((0.1, -0.6), (0.0, 0.6), 1.57), ((-0.45, 0.5), (-0.4, -0.55), -1.57))
CROSSING = (
    *(f"robots[{n}].start=[{x}, {y}]" for n, ((x, y), _, _) in enumerate(WAYS)),
    *(f"robots[{n}].goal=[{x}, {y}]" for n, (_, (x, y), _) in enumerate(WAYS)),
    *(f"robots[{n}].heading={heading}" for n, (_, _, heading) in enumerate(WAYS)),
)
