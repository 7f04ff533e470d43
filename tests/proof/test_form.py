"""The kernel is written so that its loops treat all elements alike: what the solver shows of a loop over the
elements that it can tell apart then holds of any number.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

KERNEL = Path(__file__).resolve().parents[2] / "protocol" / "kernel"
TREES = {path.name: ast.parse(path.read_text()) for path in sorted(KERNEL.glob("*.py"))}
CLASSES = [node for tree in TREES.values() for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
METHODS = {each.name for node in CLASSES for each in node.body if isinstance(each, ast.FunctionDef)}
CALLED = {node.name for node in CLASSES} | {"require", "list", "mypyc_attr", "TypeVar"}
CALLED |= METHODS | {"append", "extend", "get", "pop", "values", "items"}
NEVER = (
    ast.Break,
    ast.While,
    ast.Try,
    ast.Slice,
    ast.Lambda,
    ast.Yield,
    ast.YieldFrom,
    ast.Starred,
    ast.BinOp,
)
ORDERS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)


def strange(tree: ast.AST) -> Iterator[str]:
    """What a rule could tell elements or disks apart by, or leave some out with."""
    for node in ast.walk(tree):
        looks = STRANGE.get(type(node))
        if (isinstance(node, NEVER) and not _is_allowed(node)) or (looks is not None and looks(node)):
            yield f"line {getattr(node, 'lineno', 0)}: {ast.unparse(node)[:60]}"
        if isinstance(node, ast.FunctionDef):
            for loop in ast.walk(node):
                if isinstance(loop, ast.For):
                    yield from _strange_loop(loop, node)


def _is_allowed(node: ast.AST) -> bool:
    """A whole list in another one, or a union of types."""
    whole = isinstance(node, ast.Starred) and isinstance(node.value, ast.ListComp)
    return whole or (isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr))


def _is_by_size(node: ast.Compare) -> bool:
    """Whether a number is compared with a literal, or its size with a constant."""
    constants = [each for each in (node.left, *node.comparators) if isinstance(each, ast.Constant)]
    named = any(isinstance(each, ast.Name) and each.id.isupper() for each in (node.left, *node.comparators))
    return any(each.value is not None for each in constants) or (named and isinstance(node.ops[0], ORDERS))


def _is_one_of_many(node: ast.Subscript) -> bool:
    """Whether an element is taken by its place: but the first and the last region, and parts of a tuple."""
    by_place, at = isinstance(node.slice, ast.Constant | ast.UnaryOp), ast.unparse(node)
    return by_place and not at.endswith(("regions[0]", "regions[-1]", "][0]", "][1]", "each[0]"))


# What else is strange, by the kind of node.
STRANGE: dict[type, Callable[[Any], bool]] = {
    ast.Call: lambda node: (getattr(node.func, "id", "") or getattr(node.func, "attr", "")) not in CALLED,
    ast.Compare: _is_by_size,
    ast.Subscript: _is_one_of_many,
    ast.arguments: lambda node: not all(isinstance(each, ast.Constant | ast.Name) for each in node.defaults),
    ast.ClassDef: lambda node: any(isinstance(each, ast.Assign | ast.AnnAssign) for each in node.body),
}


def _strange_loop(loop: ast.For, function: ast.FunctionDef) -> Iterator[str]:
    inside = [each for statement in loop.body for each in ast.walk(statement)]
    for node in inside:
        if isinstance(node, ast.Return | ast.AugAssign):
            yield f"line {node.lineno}: {type(node).__name__} in a loop"
    names = [each for each in inside if isinstance(each, ast.Name)]
    outside = {each.id for each in ast.walk(function) if isinstance(each, ast.Name) and each not in names}
    outside -= {each.id for each in ast.walk(loop.target) if isinstance(each, ast.Name)}
    first: dict[str, ast.Name] = {}
    for name in sorted(names, key=lambda each: (each.lineno, isinstance(each.ctx, ast.Store))):
        first.setdefault(name.id, name)
    for word in sorted({each.id for each in names if isinstance(each.ctx, ast.Store)}):
        if not isinstance(first[word].ctx, ast.Store) or word in outside:
            yield f"line {first[word].lineno}: {word} is of another element"
    grows = [each.func.value for each in inside if isinstance(each, ast.Call) and _grows(each.func)]
    for word in {each.id for each in grows if isinstance(each, ast.Name)}:
        if any(name.id == word and name not in grows for name in names):
            yield f"line {loop.lineno}: {word} is looked at while it grows"


def _grows(called: ast.expr) -> bool:
    return isinstance(called, ast.Attribute) and called.attr in ("append", "extend")


@pytest.mark.parametrize("name", TREES)
def test_all_elements_are_treated_alike(name: str) -> None:
    assert list(strange(TREES[name])) == []


@pytest.mark.parametrize(
    "loop",
    [
        "for each in all:\n  take(each)\n  break",
        "for each in all[:2]:\n  pass",
        "for each in all:\n  if each:\n    return",
        "for each in all:\n  count += 1",
        "for each in all:\n  if last == each:\n    pass\n  last = each",
        "for each in all:\n  count = count + 1",
        "found = all[: len(all) - 1]",
        "found = [*rest]",
        "for each in all:\n  if not found:\n    take(each)\n  found.append(each)",
        "for each in all:\n  count = each\nreturn count",
        "first = all[0]",
        "all.popitem()",
        "if count > NO:\n  return",
        "if count == 1:\n  return",
        "last = count + 1",
    ],
)
def test_another_form_is_seen(loop: str) -> None:
    assert list(strange(ast.parse(f"def f(all, last, count, rest):\n{_indented(loop)}"))) != []


def _indented(text: str) -> str:
    return "".join(f"  {line}\n" for line in text.splitlines())
