"""The campaigns by name."""

from __future__ import annotations

from importlib import import_module

from tests.campaigns.campaign import Campaign

CAMPAIGNS = {  # what each searches for, and where it is
    "falsify": ("a scenario in which the filter breaks its promise", "campaigns.falsify:LOCAL"),
    "falsify-routed": (
        "the same, each scenario also on real processes and a router",
        "campaigns.falsify:ROUTED",
    ),
    "falsify-mesh": ("the same, also on real processes without one", "campaigns.falsify:MESH"),
    "faults": ("a collision under everything that may go wrong at once", "campaigns.faults:FAULTS"),
    "walk": ("a broken invariant of the lines of two robots", "campaigns.models:WALK"),
    "skirmish": ("a broken invariant of the lines of whole robots", "campaigns.models:SKIRMISH"),
    "aftermath": ("a broken invariant after a skirmish", "campaigns.models:AFTERMATH"),
    "bodies": ("a body that leaves its swept disk or its lines", "campaigns.models:BODIES"),
    "plants": ("contact of wheels in MuJoCo, under late, lost and noisy messages", "campaigns.models:PLANTS"),
    "adversary": (
        "a touch in formulas, by a law that wants one, with errors at their worst",
        "campaigns.models:ADVERSARY",
    ),
    "adversary-mujoco": ("the same in MuJoCo", "campaigns.models:ADVERSARY_MUJOCO"),
    "laws": ("a livelock of the reciprocal law where the paper's law arrives", "campaigns.laws:LAWS"),
    "movers": ("parts that do not reach their goals though there is an order", "campaigns.movers:MOVERS"),
    "movers-kill": ("the same while a robot dies with a part", "campaigns.movers:KILL"),
    "fuzz": ("damaged input that any reader does not refuse as declared", "fuzz.campaign:FUZZ"),
    "endurance": (
        "memory, handles or threads that grow; deaths not survived",
        "campaigns.endurance:ENDURANCE",
    ),
}


def find(name: str) -> Campaign:
    """The campaign of this name; it imports what it needs."""
    module, _, attribute = CAMPAIGNS[name][1].partition(":")
    found = getattr(import_module(f"tests.{module}"), attribute)
    assert isinstance(found, Campaign)
    return found
