"""Pictures and animations of recorded runs."""

from deploy.plot.draw import draw

__all__ = ["draw"]
