"""A law of the user's: found by name, and held to what a law may return."""

from __future__ import annotations

import importlib.util
import math
import sys
from collections.abc import Callable
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from agents.law.api import Law, View
from protocol.errors import LawError, UsageError
from protocol.messages import Vector
from protocol.scenario.model import Scenario

GROUP = "disknav.laws"  # of entry points
ENTRY_POINT = "entry-point"


class OwnLaw(Law):
    """Any object with `velocity`, and `slice_norm` if it has one; what it wants is checked in every tick.

    Raises:
        UsageError: there is no such law.
        LawError: it fails, or returns something else than two finite numbers; names the law and the tick.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self._name, self._speed = scenario.control.law, scenario.control.speed
        try:
            self._law = found(self._name)(scenario, robot)
        except UsageError:
            raise
        except Exception as error:
            raise LawError(f"{self._name}: cannot be made for robot {robot}: {error!r}") from error
        self._slice_norm = getattr(self._law, "slice_norm", super().slice_norm)

    def velocity(self, view: View) -> Vector:
        """See `agents.law.api.Law`; what is faster than the speed limit is slowed down to it."""
        try:
            vx, vy = (float(each) for each in self._law.velocity(view))
        except Exception as error:
            raise LawError(f"{self._name}: no velocity in tick {view.tick}: {error!r}") from error
        size = math.hypot(vx, vy)
        if not math.isfinite(size):
            raise LawError(f"{self._name}: velocity ({vx}, {vy}) in tick {view.tick}: return finite numbers")
        excess = max(1.0, size / self._speed)
        return vx / excess, vy / excess

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """See `agents.law.api.Law`."""
        try:
            norm = float(self._slice_norm(position, goal))
        except Exception as error:
            raise LawError(f"{self._name}: no slice_norm at {position}: {error!r}") from error
        if not math.isfinite(norm):
            raise LawError(f"{self._name}: slice_norm {norm} at {position}: return a finite number")
        return max(0.0, norm)


def found(name: str) -> Callable[[Scenario, int], Any]:
    """The class of a law: `module:Class`, `file.py:Class`, or `entry-point:NAME` of the group `disknav.laws`.

    Raises:
        UsageError: there is none.
    """
    module, _, attribute = name.rpartition(":")
    try:
        if module == ENTRY_POINT:
            (entry,) = entry_points(group=GROUP, name=attribute)
            law: Any = entry.load()
        else:
            owner = _from_file(Path(module)) if module.endswith(".py") else import_module(module)
            law = getattr(owner, attribute)
    except Exception as error:
        raise UsageError(f"control.law: there is no law {name!r}: {error!r}") from error
    if not callable(getattr(law, "velocity", None)):
        raise UsageError(f"control.law: {name!r} has no method velocity(view); see agents.law.api.Law")
    return law  # type: ignore[no-any-return]  # a stranger's: what it is, only its use shows


def _from_file(path: Path) -> Any:
    """The module in a file, loaded once a process."""
    name = f"disknav_law_{path.resolve()}"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, path)
        if spec is None or spec.loader is None or not path.is_file():
            raise FileNotFoundError(str(path))
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]
