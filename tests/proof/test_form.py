"""The kernel is written so that its loops treat all elements alike: what the solver shows of a loop over the
elements that it can tell apart then holds of any number.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from itertools import chain
from pathlib import Path
from typing import Any

import pytest

from tests.interpreted import interpreted

KERNEL = Path(__file__).resolve().parents[2] / "protocol" / "kernel"
TREES = {path.name: ast.parse(path.read_text()) for path in sorted(KERNEL.glob("*.py"))}
CLASSES = [node for tree in TREES.values() for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
METHODS = {each.name: each for node in CLASSES for each in node.body if isinstance(each, ast.FunctionDef)}
CALLED = {node.name for node in CLASSES} | {"require", "list", "mypyc_attr", "TypeVar"}
CALLED |= METHODS.keys() | {"append", "extend", "get", "pop", "values", "items"}
LOOPING = {
    name for name, method in METHODS.items() if any(isinstance(each, ast.For) for each in ast.walk(method))
}
KEPT = {"Held": "acknowledged granted regions", "DiskRecord": "name held phase life still"}
KEPT |= {"End": "disk life dead", "Binding": "number low high asked first told"}
KEPT |= {"Listed": "number peer first place static", "Told": "life version number region bindings"}
KEPT |= {"Pair": "living static", "Ledger": "version disks pairs _geometry"}
KEPT |= {"Bound": "number peer low state lines half place static"}
KEPT |= {"RobotLife": "name life body own part version number region offered_number offered bound _geometry"}
KEPT |= {"Owner": "held_number held number seen open", "Follower": "held_number held seen"}
FIELDS = {name: fields.split() for name, fields in KEPT.items()}  # all that the model has
ORDERS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)


def strange(tree: ast.AST) -> Iterator[str]:
    """What a rule could tell elements or disks apart by, or leave some out with."""
    placed = [each for node in ast.walk(tree) for each in _placed(node)]
    for node in ast.walk(tree):
        many = isinstance(node, ast.ListComp | ast.DictComp) or _called(node) in ("list", "values", "items")
        is_strange = STRANGE.get(type(node), lambda each: not isinstance(each, _PARTS))
        if is_strange(node) or (many and node not in placed):
            yield f"line {getattr(node, 'lineno', 0)}: {ast.unparse(node)[:60]}"
        if isinstance(node, ast.FunctionDef):
            for loop in ast.walk(node):
                if isinstance(loop, ast.For):
                    yield from _strange_loop(loop, node)


def _placed(node: ast.AST) -> list[ast.expr | None]:
    """Lists whose size nothing asks for: a loop goes through them, or they are given away or kept whole."""
    if isinstance(node, ast.For | ast.comprehension):
        return [node.iter]
    targets = getattr(node, "targets", [getattr(node, "target", None)])
    kept = isinstance(node, ast.Assign | ast.AnnAssign) and isinstance(targets[0], ast.Attribute)
    return [node.value] if kept or isinstance(node, ast.Return | ast.Starred) else []


def _is_by_size(node: ast.Compare) -> bool:
    """Whether a number is compared with a literal, or its size with a constant, or a list or region with
    another; but for `None` and disks it has to be equal, not the very same object.
    """
    if isinstance(node.ops[0], ast.Is | ast.IsNot):
        return ast.unparse(node.comparators[0]) not in ("None", "disk")
    compared = [ast.unparse(each) for each in (node.left, *node.comparators)]
    if any(each.endswith(("region", "place", "offered", "[1]")) for each in compared):
        return True
    if any(isinstance(each, ast.List | ast.Dict | ast.Tuple) for each in (node.left, *node.comparators)):
        return True
    constants = [each for each in (node.left, *node.comparators) if isinstance(each, ast.Constant)]
    named = any(isinstance(each, ast.Name) and each.id.isupper() for each in (node.left, *node.comparators))
    return any(each.value is not None for each in constants) or (named and isinstance(node.ops[0], ORDERS))


def _is_one_of_many(node: ast.Subscript) -> bool:
    """Whether an element is taken by its place: but the first and the last region, and parts of a tuple."""
    by_place, at = isinstance(node.slice, ast.Constant | ast.UnaryOp), ast.unparse(node)
    return by_place and not at.endswith(("regions[0]", "regions[-1]", "][0]", "][1]", "each[0]"))


def _is_a_number(node: ast.Assign | ast.AnnAssign) -> bool:
    """Whether a literal gets a name within a rule."""
    literal = any(isinstance(each, ast.Constant) for each in (node.value, *getattr(node.value, "elts", ())))
    names = [each for each in ast.walk(node) if isinstance(each, ast.Name)]
    return literal and not all(each.id.isupper() for each in names if isinstance(each.ctx, ast.Store))


def _is_no_record(node: ast.ClassDef) -> bool:
    """Whether a class keeps or inherits anything but its fields."""
    made = [ast.unparse(each) for each in (*node.bases, *node.keywords, *node.decorator_list)]
    body = node.body[1:] if ast.get_docstring(node) else node.body
    return (
        not all(each.startswith(("Generic[", "Protocol[", "DisknavError", "mypyc_attr(")) for each in made)
        or not all(isinstance(each, ast.FunctionDef) for each in body)
        or not _fields_of(node) <= set(FIELDS.get(node.name, ()))
    )


_PARTS = (ast.expr_context, ast.boolop, ast.operator, ast.unaryop, ast.cmpop)
_PLAIN = "BoolOp Continue DictComp Expr For If IfExp List ListComp Raise Return Tuple arg comprehension"
_FROM = ("__future__", "collections.abc", "typing", "mypy_extensions", "protocol.errors")
STRANGE: dict[type, Callable[[Any], bool]] = {
    **{getattr(ast, name): lambda _: False for name in (*_PLAIN.split(), "keyword")},
    ast.alias: lambda node: node.asname is not None,
    ast.AnnAssign: _is_a_number,
    ast.Assign: _is_a_number,
    ast.Attribute: lambda node: isinstance(node.ctx, ast.Store) and node.attr not in chain(*FIELDS.values()),
    ast.AugAssign: lambda node: not isinstance(node.target, ast.Attribute),
    ast.Constant: lambda node: isinstance(node.value, int | float | bytes) and node.value not in (0, 1, 2),
    ast.Dict: lambda node: None in node.keys,
    ast.ImportFrom: lambda node: node.module not in _FROM and not node.module.startswith("protocol.kernel."),
    ast.UnaryOp: lambda node: not isinstance(node.op, ast.Not) and ast.unparse(node) != "-1",
    ast.Starred: lambda node: not isinstance(node.value, ast.ListComp),  # but a whole list in another one
    ast.BinOp: lambda node: not isinstance(node.op, ast.BitOr),  # but a union of types
    ast.Call: lambda node: not _is_known(node),
    ast.Compare: _is_by_size,
    ast.Name: lambda node: node.id == "require" and isinstance(node.ctx, ast.Store),
    ast.Subscript: _is_one_of_many,
    ast.arguments: lambda node: "*" in ast.unparse(node) or _defaults(node) not in ([], ["part: int=NO"]),
    ast.ClassDef: _is_no_record,
    ast.FunctionDef: lambda node: (
        any(ast.unparse(each) != "property" for each in node.decorator_list)
        or (node.name.startswith("__") and node.name != "__init__")
    ),
    ast.Module: lambda node: not all(_is_constant(each) for each in node.body),
}


def _is_known(node: ast.Call) -> bool:
    """Whether a rule calls what the kernel has, or a method that leaves out no element."""
    called, of = _called(node), ast.unparse(node.func).removesuffix(f".{_called(node)}")
    if called in METHODS and hasattr(list, called):
        return of == "self._geometry"
    return called in CALLED and (called != "pop" or len(node.args) == 2)


def _called(node: ast.AST) -> str:
    called = getattr(node, "func", None)
    return getattr(called, "id", "") or getattr(called, "attr", "")


def _fields_of(node: ast.ClassDef) -> set[str]:
    """Fields of itself that a class writes."""
    fields = [each for each in ast.walk(node) if isinstance(each, ast.Attribute)]
    stored = [each for each in fields if isinstance(each.ctx, ast.Store)]
    return {each.attr for each in stored if ast.unparse(each.value) == "self"}


def _defaults(node: ast.arguments) -> list[str]:
    return [each for each in ast.unparse(node).split(", ") if "=" in each]


def _is_constant(node: ast.stmt) -> bool:
    """Whether a statement of a module makes nothing that a rule could change."""
    if isinstance(node, ast.Assign | ast.AnnAssign):
        return isinstance(node.value, ast.Constant) or ast.unparse(node.value or node).startswith("TypeVar(")
    is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    return is_text or isinstance(node, ast.ImportFrom | ast.FunctionDef | ast.ClassDef)


def _strange_loop(loop: ast.For, function: ast.FunctionDef) -> Iterator[str]:
    inside = [each for statement in loop.body for each in ast.walk(statement)]
    for node in inside:
        again = isinstance(node, ast.Call) and _called(node) in LOOPING
        again |= isinstance(node, ast.For) and not isinstance(node.iter, ast.Tuple)
        if again or isinstance(node, ast.Return | ast.AugAssign | ast.ListComp):
            yield f"line {node.lineno}: {ast.unparse(node)[:60]} in a loop"
    yield from _of_another(inside, loop)
    yield from _looked_at(inside, function)
    names = [each for each in inside if isinstance(each, ast.Name)]
    outside = {each.id for each in ast.walk(function) if isinstance(each, ast.Name) and each not in names}
    outside -= {each.id for each in ast.walk(loop.target) if isinstance(each, ast.Name)}
    first: dict[str, ast.Name] = {}
    for name in sorted(names, key=lambda each: (each.lineno, isinstance(each.ctx, ast.Store))):
        first.setdefault(name.id, name)
    always = [
        each
        for around in ast.walk(loop)
        if isinstance(around, ast.For | ast.ListComp)
        for assigned in (*getattr(around, "body", ()), getattr(around, "target", around))
        if isinstance(assigned, ast.Assign | ast.AnnAssign | ast.expr)
        for each in ast.walk(assigned)
    ]
    for word in sorted({each.id for each in names if isinstance(each.ctx, ast.Store)}):
        if not isinstance(first[word].ctx, ast.Store) or first[word] not in always or word in outside:
            yield f"line {first[word].lineno}: {word} is of another element"


def _of_another(inside: list[ast.AST], loop: ast.For) -> Iterator[str]:
    """Fields by which a rule could tell one element what it did with another."""
    fields = [each for each in inside if isinstance(each, ast.Attribute)]
    written = {each.attr for each in fields if isinstance(each.ctx, ast.Store)}
    of_element = {each.id for each in ast.walk(loop.target) if isinstance(each, ast.Name)}
    for node in fields:
        mine = isinstance(node.value, ast.Name) and node.value.id in of_element
        if node.attr in written and not isinstance(node.ctx, ast.Store) and not mine:
            yield f"line {node.lineno}: {node.attr} may be of another element"


def _looked_at(inside: list[ast.AST], function: ast.FunctionDef) -> Iterator[str]:
    """Lists that a loop extends are given away whole."""
    grows = [each.func.value for each in inside if isinstance(each, ast.Call) and _grows(each.func)]
    given = [each for node in ast.walk(function) for each in _given(node)]
    for word in {each.id for each in grows if isinstance(each, ast.Name)}:
        looked_at = [each for each in ast.walk(function) if isinstance(each, ast.Name) and each.id == word]
        for name in looked_at:
            if isinstance(name.ctx, ast.Load) and name not in grows and name not in given:
                yield f"line {name.lineno}: {word} is looked at"


def _given(node: ast.AST) -> list[ast.expr | None]:
    """What a function returns, or makes a record of."""
    if isinstance(node, ast.Return):
        return [node.value]
    return [*node.args] if isinstance(node, ast.Call) and _called(node) in FIELDS else []


def _grows(called: ast.expr) -> bool:
    return isinstance(called, ast.Attribute) and called.attr in ("append", "extend")


@pytest.mark.parametrize("name", TREES)
def test_all_elements_are_treated_alike(name: str) -> None:
    assert list(strange(TREES[name])) == []


@pytest.mark.parametrize(
    "loop",
    [
        "for each in all:\n  take(each)\n  break", "for each in all[:2]:\n  pass",
        "for each in all:\n  if each:\n    return", "for each in all:\n  count += 1",
        "for each in all:\n  if last == each:\n    pass\n  last = each",
        "for each in all:\n  count = count + 1", "found = all[: len(all) - 1]", "found = [*rest]",
        "for each in all:\n  if not found:\n    take(each)\n  found.append(each)",
        "for each in all:\n  count = each\nreturn count", "first = all[0]", "all.popitem()",
        "if count > NO:\n  return", "if count == 1:\n  return", "last = count + 1",
        "for each in all:\n  for other in all:\n    take(each, other)",
        "for each in all:\n  last.phase = each.phase == last.phase",
        "for each in all:\n  rest.append(each)\nif rest:\n  return", "all.pop()", "all.remove(last)",
        "del all[last]", "if all == []:\n  return", "global LAST",
        "class Held:\n  def grant(self):\n    self.hidden = last", "@cache\ndef tied():\n  return last",
        "if last is NO:\n  return", "match count:\n  case 7:\n    return", "if count in {7}:\n  return",
        "if count == -7:\n  return", "seven = 1", "try:\n  take(last)\nexcept* RefusedError:\n  return",
        "from os import environ", "def grant(self, sure=True):\n  return", "class Held:\n  (kept := last)",
        "class Held(list):\n  def grant(self):\n    return", "def __getattr__(self, name):\n  return last",
        "last.hidden = count", "found = [each for each in all]\nif found:\n  return",
        "if all.values():\n  return", "if list(all) == rest:\n  return",
        "if last.region == count:\n  return",
        "for each in all:\n  if each.still:\n    kept = each\n  if kept.still:\n    continue",
    ],
)  # fmt: skip
def test_another_form_is_seen(loop: str) -> None:
    assert list(strange(ast.parse(f"def f(all, last, count, rest):\n{_indented(loop)}"))) != []


def test_a_module_keeps_nothing() -> None:
    assert list(strange(ast.parse("KEPT = []"))) != []


@pytest.mark.parametrize("holds", [True, False])
def test_a_precondition_that_does_not_hold_is_refused(holds: bool) -> None:
    (require,) = [each for each in TREES["records.py"].body if isinstance(each, ast.FunctionDef)]
    assert ast.unparse(require.body[-1]).split() == ["if", "not", "holds:", "raise", "RefusedError(what)"]
    (records,) = interpreted("protocol.kernel.records")
    with nullcontext() if holds else pytest.raises(records.RefusedError, match="rule: what"):
        records.require(holds, "rule: what")


def _indented(text: str) -> str:
    return "".join(f"  {line}\n" for line in text.splitlines())
