"""Which law a scenario asks for: one of this software, or one from outside, held to what a law may return."""

from __future__ import annotations

import ast
import importlib.util
import math
import re
import sys
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, Final

from agents.law.additions import AugmentedLaw
from agents.law.api import Law, View
from agents.law.gradient import GradientLaw
from protocol.errors import LawError, UsageError
from protocol.messages import Vector
from protocol.scenario.model import Scenario


class ExternalLaw(Law):
    """The newest wish, at most the speed limit; none once it is older than `control.lifetime`."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        del robot
        self._speed, self._lifetime = scenario.control.speed, scenario.ticks(scenario.control.lifetime)
        self._wish: Vector = (0.0, 0.0)
        self._until = -1  # tick up to which it counts

    def tell(self, wish: Vector, tick: int) -> None:
        """Take a wish, m/s, that came during `tick`."""
        excess = max(1.0, math.hypot(*wish) / self._speed)
        self._wish = wish[0] / excess, wish[1] / excess
        self._until = tick + self._lifetime

    def velocity(self, view: View) -> Vector:
        """Desired velocity, m/s."""
        return self._wish if view.tick <= self._until else (0.0, 0.0)


MOST: Final = 1e3  # radii of the workspace: the largest slice that peers are told
GROUP: Final = "disknav.laws"  # of entry points
ENTRY_POINT: Final = "entry-point"
_NAME: Final = re.compile(r"(?s)(.+):([^:()]+)(?:\((.*)\))?")  # module, class, arguments


def choose(scenario: Scenario, robot: int) -> Law:
    """The law of `scenario.control.law` for one robot.

    Raises:
        UsageError: there is no such law, or a library that it needs is not installed.
        LawError: a law from outside cannot be made.
    """
    law = scenario.control.law
    if law == "reciprocal":
        from agents.law.reciprocal import ReciprocalLaw

        return ReciprocalLaw(scenario, robot)
    if law == "external":
        return ExternalLaw(scenario, robot)
    if ":" in law:
        return OwnLaw(scenario, robot)
    return AugmentedLaw(scenario, robot) if scenario.control.additions else GradientLaw(scenario, robot)


class GuardedLaw(Law):
    """The law that a scenario asks for, and none from its first failure on: then the robot stands.

    What it tells peers of its slice is bounded. A squeezed disk, or a peer with an absurd gamma, makes
    it larger than any number that a State may hold; at the common pace no slice counts for more than the
    largest attraction, which is below the bound.

    Args:
        scenario: the run.
        robot: id of the robot to control.

    Attributes:
        failure: what failed; "" if nothing did.

    Raises:
        UsageError: there is no such law, or a library that it needs is not installed.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self.failure = ""
        self._most = MOST * scenario.workspace.shape.around.radius
        self._law: Law | None = None
        try:
            self._law = choose(scenario, robot)
        except LawError as error:
            self.failure = str(error)

    def tell(self, wish: Vector, tick: int) -> None:
        """A wish from outside, m/s, during `tick`; only the law "external" is told."""
        if isinstance(self._law, ExternalLaw):
            self._law.tell(wish, tick)

    def velocity(self, view: View) -> Vector:
        """Desired velocity, m/s; 0 once the law has failed."""
        if self._law is not None:
            try:
                return self._law.velocity(view)
            except LawError as error:
                self._law, self.failure = None, str(error)
        return 0.0, 0.0

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """|D_i|, m, at most the bound; that of the attraction alone once the law has failed."""
        if self._law is not None:
            try:
                return min(self._law.slice_norm(position, goal), self._most)
            except LawError as error:
                self._law, self.failure = None, str(error)
        return min(super().slice_norm(position, goal), self._most)


class OwnLaw(Law):
    """A law from outside: any object with `velocity`, and `slice_norm` if it has one, checked in every tick.

    Raises:
        UsageError: there is no such law.
        LawError: it fails, or returns something else than finite numbers; names the law and the tick.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self._name, self._speed = scenario.control.law, scenario.control.speed
        law, arguments = found(self._name)
        try:
            self._law = law(scenario, robot, **arguments)
        except UsageError:
            raise
        except Exception as error:
            raise LawError(f"{self._name}: cannot be made for robot {robot}: {error!r}") from error
        self._slice_norm = getattr(self._law, "slice_norm", super().slice_norm)

    def velocity(self, view: View) -> Vector:
        """Desired velocity, m/s; what is faster than the speed limit is slowed down to it."""
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
        """|D_i|, m, not negative."""
        try:
            norm = float(self._slice_norm(position, goal))
        except Exception as error:
            raise LawError(f"{self._name}: no slice_norm at {position}: {error!r}") from error
        if not math.isfinite(norm):
            raise LawError(f"{self._name}: slice_norm {norm} at {position}: return a finite number")
        return max(0.0, norm)


def found(name: str) -> tuple[Any, dict[str, Any]]:
    """The class of a law and its keyword arguments beside scenario and robot.

    `module:Class`, `file.py:Class`, or `entry-point:NAME` of the group `disknav.laws`, each with arguments in
    parentheses if it takes any, such as `module:Class(gain=2.0)`.

    Raises:
        UsageError: there is none, or its arguments cannot be read.
    """
    parts = _NAME.fullmatch(name)
    if parts is None:
        raise UsageError(f"control.law: {name!r} is not module:Class or module:Class(name=value)")
    module, attribute, arguments = parts.groups()
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
        raise UsageError(f"control.law: {name!r} has no method velocity(view), as agents.law.api.Law has")
    return law, _arguments(name, arguments or "")


def _arguments(name: str, text: str) -> dict[str, Any]:
    try:
        call = ast.parse(f"law({text})", mode="eval").body
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name)) or call.args:
            raise ValueError("write name=value, separated by commas")
        return {str(each.arg): ast.literal_eval(each.value) for each in call.keywords}
    except (SyntaxError, ValueError) as error:
        raise UsageError(f"control.law: the arguments of {name!r} cannot be read: {error}") from None


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
