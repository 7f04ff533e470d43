"""A sign turned in any contractor or form is caught by boxes around known critical points."""

from __future__ import annotations

import warnings
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

from deploy.theory.certify.boxes import derived, scene_of
from deploy.theory.function import Array
from tests.deploy.theory.certify import forms
from tests.deploy.theory.certify.known import Known, blockade, boxes, holds, known
from tests.deploy.theory.certify.mutants import mutant

pytestmark = pytest.mark.slow

_TABLE = """
distance of a pair | contractors | if j < 0 else sub(far, contact) | if j < 0 else sub(contact, far)
distance that is left | contractors | if j < 0 else add(contact, beta) | if j < 0 else sub(contact, beta)
distance of the other robot | contractors | moved = sub((box[one, 0] | moved = add((box[one, 0]
multiplier at contact | contractors | out.total[1, 1] / out.beta[q, 0] | out.total[1, 0] / out.beta[q, 0]
force of a wall | contractors | return -_inside(members, i) | return _inside(members, i)
force on the second robot | contractors | _inside(members, i) - _inside | _inside(members, i) + _inside
force that places a robot | contractors | rest = sub(rest, (out.pull | rest = add(rest, (out.pull
torque | contractors | torque = add(torque, turn if sign > 0 | torque = add(torque, turn if sign < 0
torque, one coordinate | contractors | rest = sub(rest, _moment | rest = add(rest, _moment
work of a wall | contractors | total if j >= 0 else (-total[1], -total[0]) | total
work of the others | contractors | rest = sub(rest, _share | rest = add(rest, _share
sum of w over beta | contractors | out.beta[q, 0] if most > 0.0 | out.beta[q, 1] if most > 0.0
newton, value | search | rest = sub(rest, mul((inverse[row, r] | rest = add(rest, mul((inverse[row, r]
newton, force | search | _put(slope, two, n + q, here) | _put(slope, two, n + q, (-here[1], -here[0]))
newton, gamma | search | slope[n + q, row] = -both[1], -both[0] | slope[n + q, row] = both[0], both[1]
newton, beta | search | n + q, two, (-along[1], -along[0])) | n + q, two, along)
rotation of the fleet | curvature | if total < 0.0: | if total > 0.0:
rotation, one coordinate | curvature | down(-rest / goal) | down(rest / goal)
circle, pairs | curvature | up(gain - box[n + r, 0]) | up(gain - up(2.0 * box[n + r, 1]))
circle, walls | curvature | up(gain + box[n + r, 1]) | up(gain - box[n + r, 1])
circle, bend | curvature | up(up(gain * far[0]) + bend) | up(up(gain * far[0]) - bend)
form, pairs | curvature | down(box[n + q, 0] * max | down(2.0 * box[n + q, 1] * max
form, walls | curvature | up(total + up(box[n + q, 1] | up(total - up(box[n + q, 1]
form, bend | curvature | up(2.0 * up(stiffness(box, out, n, q) * | up(-2.0 * up(stiffness(box, out, n, q) *
correction | curvature | value = sub(value, mul((basis | value = add(value, mul((basis
"""  # name | module | what it says | with a sign turned
MUTANTS = {name: tuple(rest) for name, *rest in (line.split(" | ") for line in _TABLE.strip().splitlines())}


def pool() -> list[Known]:
    """Minima first, then saddles of two to four robots, at the wall too."""
    minima = [blockade(2.2), blockade(2.4)]
    found = [each for seed in range(40) for each in known(seed)]
    minima += [each for each in found if each.point.kind == "minimum"][:12]
    return minima + [each for each in found if each.point.kind == "saddle"][:60]


def caught(search: ModuleType, count: int) -> bool:
    """Whether a box loses its critical point, is settled though it holds a minimum, or a bound is none."""
    if any(_wrong(search, found, box) for found, box in _boxes(1)):
        return True
    try:
        forms.circling_is_bounded(import_module(f"{search.__package__}.curvature"), pool())
        forms.fields_are_orthogonal(import_module(f"{search.__package__}.curvature"), pool()[::8])
        forms.form_is_bounded(import_module(f"{search.__package__}.curvature"), pool()[::4])
    except AssertionError:
        return True
    return any(_wrong(search, found, box) for found, box in _boxes(count))


def _boxes(count: int) -> list[tuple[Known, Array]]:
    return [(found, box) for seed in range(count) for found in pool() for box in boxes(found, 1, seed)]


def _wrong(search: ModuleType, found: Known, box: Array) -> bool:
    scene = scene_of(found.problem)
    out, row = derived(scene), found.row
    copy = box.copy()
    if found.point.kind == "minimum":
        return search.settle(scene, copy, out) != search.OPEN or not holds(copy, row)
    kept = search.contract(scene, copy, out) and search.contract_newton(scene, copy, out)
    return not (kept and holds(copy, row))


@pytest.mark.campaign  # each compiles the search anew
@pytest.mark.parametrize("name", MUTANTS)
def test_a_turned_sign_is_caught(name: str, tmp_path: Path) -> None:
    module, says, instead = MUTANTS[name]
    search = mutant(tmp_path, f"mutant_{list(MUTANTS).index(name)}", f"{module}.py", says, instead)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert caught(search, 6)


@pytest.mark.campaign
def test_the_sources_as_they_are_are_not(tmp_path: Path) -> None:
    search = mutant(
        tmp_path, "mutant_none", "contractors.py", '"""Derive w_q of every factor."""', '"""The same."""'
    )
    assert not caught(search, 1)
