"""Three robots: the straight ways of two lead through each other, and through that of the third."""

WAYS = (((-0.6, 0.0), (0.6, 0.1), 0.0), ((0.1, -0.6), (0.0, 0.6), 1.57), ((-0.2, 0.62), (0.5, -0.5), -1.0))
CROSSING = (
    *(f"robots[{n}].start=[{x}, {y}]" for n, ((x, y), _, _) in enumerate(WAYS)),
    *(f"robots[{n}].goal=[{x}, {y}]" for n, (_, (x, y), _) in enumerate(WAYS)),
    *(f"robots[{n}].heading={heading}" for n, (_, _, heading) in enumerate(WAYS)),
)
