"""The law of a scenario: built in, or external, with checks of its results."""

from __future__ import annotations

import ast
import importlib.util
import math
import re
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, Final

from agents.law.additions import AugmentedLaw
from agents.law.api import Law, View, attraction
from agents.law.gradient import GradientLaw
from protocol.errors import LawError, UsageError
from protocol.messages import Vector
from protocol.scenario.model import Scenario


class ExternalLaw(Law):
    """The newest wish, limited to the speed limit; zero once it is older than `control.lifetime`."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        del robot
        self._speed, self._lifetime = scenario.control.speed, scenario.ticks(scenario.control.lifetime)
        self._wish: Vector = (0.0, 0.0)
        self._until = -1  # tick up to which the wish is valid

    def on_wish(self, wish: Vector, tick: int) -> None:
        """Take a wish, m/s, received during `tick`."""
        excess = max(1.0, math.hypot(*wish) / self._speed)
        self._wish = wish[0] / excess, wish[1] / excess
        self._until = tick + self._lifetime

    def velocity(self, view: View) -> Vector:
        return self._wish if view.tick <= self._until else (0.0, 0.0)


MOST: Final = 1e3  # largest slice sent to peers, radii of the workspace
GROUP: Final = "disknav.laws"  # of entry points
ENTRY_POINT: Final = "entry-point"
_NAME: Final = re.compile(r"(?s)(.+):([^:()]+)(?:\((.*)\))?")  # module, class, arguments


def choose(scenario: Scenario, robot: int) -> Law:
    """The law of `scenario.control.law` for one robot.

    Raises:
        UsageError: there is no such law, or one of its libraries is not installed.
    """
    law = scenario.control.law
    if law == "reciprocal":
        from agents.law.reciprocal import ReciprocalLaw

        return ReciprocalLaw(scenario, robot)
    if law == "external":
        return ExternalLaw(scenario, robot)
    if ":" in law:
        kind, arguments = found(law)
        outside: Law = kind(scenario, robot, **arguments)
        return outside
    return AugmentedLaw(scenario, robot) if scenario.control.additions else GradientLaw(scenario, robot)


class GuardedLaw:
    """The scenario's law. An external law must return finite numbers; after a failure the robot stands.

    The slice sent to peers is bounded: a squeezed disk, or a peer with an absurd gamma, may exceed any number
    that a State may hold. The common pace limits slices to the largest attraction, which is below this bound.

    Raises:
        UsageError: as `choose`.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self.failure = ""  # names the law and its first failure; "" if it has not failed
        self._name, self._speed = scenario.control.law, scenario.control.speed
        self._most = MOST * scenario.workspace.shape.around.radius
        self._from_outside = ":" in self._name
        self._law: Law | None = None
        with self._guarded(f"cannot be constructed for robot {robot}", UsageError):
            self._law = choose(scenario, robot)

    def on_wish(self, wish: Vector, tick: int) -> None:
        """Pass a wish, m/s, received during `tick`, to the law "external"; others ignore it."""
        if isinstance(self._law, ExternalLaw):
            self._law.on_wish(wish, tick)

    def velocity(self, view: View) -> Vector:
        """Desired velocity, m/s, at most the speed limit; 0 after a failure."""
        if self._law is not None and not self._from_outside:
            return self._law.velocity(view)
        if self._law is not None:
            with self._guarded(f"no velocity in tick {view.tick}"):
                vx, vy = _finite(self._law.velocity, 2, "two finite numbers, m/s", view)
                excess = max(1.0, math.hypot(vx, vy) / self._speed)
                return vx / excess, vy / excess
        return 0.0, 0.0

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """|D_i|, m, at most the bound; that of the attraction alone once the law has failed."""
        if self._law is not None and not self._from_outside:
            return min(self._law.slice_norm(position, goal), self._most)
        if self._law is not None and hasattr(self._law, "slice_norm"):
            with self._guarded(f"no slice_norm at {position}"):
                (size,) = _finite(self._law.slice_norm, 1, "a finite number, m", position, goal)
                return min(max(0.0, size), self._most)
        return min(attraction(position, goal), self._most)

    @contextmanager
    def _guarded(self, what: str, *passed: type[Exception]) -> Iterator[None]:
        """Record the failure of an external law, which is not called again; errors `passed` are raised."""
        try:
            yield
        except passed:
            raise
        except Exception as error:
            if not self._from_outside:
                raise
            at = traceback.extract_tb(error.__traceback__)[-1]
            said = f"{error!r} in {at.filename}, line {at.lineno}"
            said = str(error) if isinstance(error, LawError) else said
            self._law, self.failure = None, f"{self._name}: {what}: {said}"


def _finite(method: Any, count: int, expected: str, *given: Any) -> list[float]:
    """Numbers that a law's method returns; raises LawError if it returns anything else."""
    returned = method(*given)
    with suppress(TypeError, ValueError):
        numbers = [float(each) for each in (returned if count > 1 else (returned,))]
        if len(numbers) == count and math.isfinite(math.hypot(*numbers)):
            return numbers
    raise LawError(f"returned {returned!r:.80}, not {expected}")


def found(name: str) -> tuple[Any, dict[str, Any]]:
    """The class of a law, and its keyword arguments besides scenario and robot.

    `module:Class`, `file.py:Class`, or `entry-point:NAME` of the group `disknav.laws`, with arguments in
    parentheses if there are any, such as `module:Class(gain=2.0)`.

    Raises:
        UsageError: there is no such law, or its arguments are invalid.
    """
    parts = _NAME.fullmatch(name)
    if parts is None:
        raise UsageError(f"the law {name!r} is not module:Class or module:Class(name=value)")
    module, attribute, arguments = parts.groups()
    try:
        if module == ENTRY_POINT:
            (entry,) = entry_points(group=GROUP, name=attribute)
            law: Any = entry.load()
        else:
            owner = _from_file(Path(module)) if module.endswith(".py") else import_module(module)
            law = getattr(owner, attribute)
    except Exception as error:
        raise UsageError(f"there is no law {name!r}: {type(error).__name__}: {error}") from error
    if not callable(getattr(law, "velocity", None)):
        raise UsageError(f"the law {name!r} has no method velocity(view), as agents.law.api.Law has")
    return law, _arguments(name, arguments or "")


def _arguments(name: str, text: str) -> dict[str, Any]:
    try:
        call = ast.parse(f"law({text})", mode="eval").body
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name)) or call.args:
            raise ValueError("write name=value, separated by commas")
        return {str(each.arg): ast.literal_eval(each.value) for each in call.keywords}
    except (SyntaxError, ValueError) as error:
        raise UsageError(f"the arguments of the law {name!r} cannot be read: {error}") from None


def _from_file(path: Path) -> Any:
    """The module of a file, loaded once per process."""
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
