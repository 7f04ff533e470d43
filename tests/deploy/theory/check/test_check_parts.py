"""What `disknav check` says of parts: no theorem, and whether one after another finds its way."""

from __future__ import annotations

from dataclasses import replace

from deploy.library.load import load
from deploy.theory.check.scope import theorem_for
from deploy.theory.check.surrounded import surrounded


def test_parts_have_no_theorem_and_may_have_an_order() -> None:
    found = surrounded(load("parts-4", [], 1))
    assert (found.theorem, found.parts, found.order) == (None, 4, True)


def test_two_parts_that_change_places_have_no_order() -> None:
    drawn = load("parts-2", [], 0)
    one, other = drawn.parts
    swapped = (replace(one, goal=other.start), replace(other, goal=one.start))
    assert surrounded(replace(drawn, parts=swapped)).order is False


def test_a_single_robot_with_parts_is_in_no_sphere_world() -> None:
    drawn = load("parts-2", [], 0)
    theorem, reasons = theorem_for(replace(drawn, robots=drawn.robots[:1]))
    assert theorem is None
    assert "parts that are carried" in reasons[0]
