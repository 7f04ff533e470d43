"""The campaigns by name."""

import sys
from importlib import import_module
from importlib.machinery import SOURCE_SUFFIXES, FileFinder, SourceFileLoader
from pathlib import Path

from tests.campaigns.campaign import Campaign

CAMPAIGNS = {  # what each searches for, and where it is
    "falsify": ("a scenario in which the filter breaks its promise", "falsify:LOCAL"),
    "falsify-routed": ("the same, each scenario also on real processes and a router", "falsify:ROUTED"),
    "falsify-mesh": ("the same, also on real processes without one", "falsify:MESH"),
    "falsify-mortal": ("the same while worlds die, at any message", "falsify:MORTAL"),
    "faults": ("a collision under everything that may go wrong at once", "faults:FAULTS"),
    "skirmish": ("a broken invariant of the lines of whole robots", "models:SKIRMISH"),
    "aftermath": ("a broken invariant after a skirmish", "models:AFTERMATH"),
    "mortal-floor": ("contact of external bases, under worlds and processes that die", "mortal_floor:FLOOR"),
    "bodies": ("a body that leaves its swept disk or its lines", "models:BODIES"),
    "adversary": (
        "a touch in formulas, by a law that wants one, with errors at their worst",
        "models:ADVERSARY",
    ),
    "adversary-mujoco": ("the same of wheels in MuJoCo", "models:ADVERSARY_MUJOCO"),
    "deviations": ("a body in MuJoCo that is off its way by more than it states", "models:DEVIATIONS"),
    "worlds": ("a contact, or something forgotten, when the world dies at any moment", "models:WORLDS"),
    "laws": ("a livelock of the reciprocal law where the paper's law arrives", "laws:LAWS"),
    "movers": ("parts that do not reach their goals though there is an order", "movers:MOVERS"),
    "fuzz": ("damaged input that any reader does not refuse as declared", "fuzz.campaign:FUZZ"),
    "endurance": ("memory, handles or threads that grow; deaths not survived", "endurance:ENDURANCE"),
}


_ROOT = Path(__file__).resolve().parents[2]
# Parts of the product, or derived from them.
_REPLACING = "falsify", "skirmish", "aftermath", "mortal-floor", "bodies"


def find(name: str) -> Campaign:
    """The campaign of this name; it imports what it needs."""
    if name.startswith(_REPLACING) and _of_sources not in sys.path_hooks:
        sys.path_hooks.insert(0, _of_sources)
        sys.path_importer_cache.clear()
    module, _, attribute = CAMPAIGNS[name][1].partition(":")
    return getattr(import_module(f"tests.campaigns.{module}"), attribute)


def _of_sources(folder: str) -> FileFinder:
    """Finds sources alone, whatever is compiled: compiled modules refuse replaced ones."""
    parts = Path(folder).resolve().parts
    if parts[: len(_ROOT.parts)] != _ROOT.parts or ".venv" in parts:
        raise ImportError(folder)
    return FileFinder(folder, (SourceFileLoader, SOURCE_SUFFIXES))
