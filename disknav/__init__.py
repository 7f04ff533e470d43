"""disknav from Python: load or build a scenario, run or step it, and get the results as arrays.

    import disknav

    run = disknav.run("figure-1")
    print(run.verdict, run.trajectory.positions.shape)

docs/guides/python.md is the guide. The command `disknav` uses the same code. Names are imported at first use,
after a check that their packages are disknav's own.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from deploy.telemetry.recording.reader import Recording as Recording
    from deploy.telemetry.recording.reader import read as read
    from deploy.telemetry.recording.trajectory import Trajectory as Trajectory
    from disknav.environment import parallel_env as parallel_env
    from disknav.filtering import filtered as filtered
    from disknav.orders import FleetOrders as FleetOrders
    from disknav.orders import Orders as Orders
    from disknav.orders import operate as operate
    from disknav.running import Run as Run
    from disknav.running import Simulation as Simulation
    from disknav.running import run as run
    from disknav.scenarios import build as build
    from disknav.scenarios import library as library
    from disknav.scenarios import load as load
    from protocol.errors import BusError as BusError
    from protocol.errors import CertificateError as CertificateError
    from protocol.errors import DisknavError as DisknavError
    from protocol.errors import LawError as LawError
    from protocol.errors import ProcessError as ProcessError
    from protocol.errors import ScenarioError as ScenarioError
    from protocol.errors import UsageError as UsageError
    from protocol.scenario.model import Scenario as Scenario

_MODULES = {
    "deploy.telemetry.recording.reader": ("Recording", "read"),
    "deploy.telemetry.recording.trajectory": ("Trajectory",),
    "disknav.environment": ("parallel_env",),
    "disknav.filtering": ("filtered",),
    "disknav.orders": ("FleetOrders", "Orders", "operate"),
    "disknav.running": ("Run", "Simulation", "run"),
    "disknav.scenarios": ("build", "library", "load"),
    "protocol.errors": (
        "BusError",
        "CertificateError",
        "DisknavError",
        "LawError",
        "ProcessError",
        "ScenarioError",
        "UsageError",
    ),
    "protocol.scenario.model": ("Scenario",),
}
_FROM = {name: module for module, names in _MODULES.items() for name in names}
__all__ = sorted(_FROM.keys() - {"parallel_env"})  # noqa: PLE0605  # which needs an extra


def __getattr__(name: str) -> Any:
    if name not in _FROM:
        raise AttributeError(f"module 'disknav' has no attribute {name!r}; it has {', '.join(__dir__())}")
    from disknav import ownership

    ownership.check()
    found = globals()[name] = getattr(import_module(_FROM[name]), name)
    return found


def __dir__() -> list[str]:
    return sorted(_FROM)
