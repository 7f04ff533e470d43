"""The kernel is written so that its loops treat all elements alike: what the solver shows of a loop over the
elements that it can tell apart then holds of any number.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

KERNEL = Path(__file__).resolve().parents[2] / "protocol" / "kernel"
TREES = {path.name: ast.parse(path.read_text()) for path in sorted(KERNEL.glob("*.py"))}
# What may be called by its name; the rest are methods.
CALLED = {node.name for tree in TREES.values() for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}
CALLED |= {"require", "list", "mypyc_attr", "TypeVar"}
LEAVE_EARLY = (ast.Break, ast.While, ast.Try, ast.Slice, ast.Lambda, ast.Yield, ast.YieldFrom, ast.Starred)


def strange(tree: ast.AST) -> Iterator[str]:
    """What a loop could tell elements apart by, or leave some out with."""
    for node in ast.walk(tree):
        if isinstance(node, LEAVE_EARLY) and not _is_whole(node):
            yield f"line {node.lineno}: {type(node).__name__}"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id not in CALLED:
            yield f"line {node.lineno}: {node.func.id}()"
        if isinstance(node, ast.For):
            yield from _strange_loop(node)


def _is_whole(node: ast.AST) -> bool:
    """Whether it is a whole list in another one."""
    return isinstance(node, ast.Starred) and isinstance(node.value, ast.ListComp)


def _strange_loop(loop: ast.For) -> Iterator[str]:
    inside = [each for statement in loop.body for each in ast.walk(statement)]
    for node in inside:
        if isinstance(node, ast.Return | ast.AugAssign):
            yield f"line {node.lineno}: {type(node).__name__} in a loop"
    first: dict[str, ast.Name] = {}
    names = [each for each in inside if isinstance(each, ast.Name)]
    for name in sorted(names, key=lambda each: (each.lineno, isinstance(each.ctx, ast.Store))):
        first.setdefault(name.id, name)
    stored = {each.id for each in inside if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)}
    for word in sorted(stored):
        if not isinstance(first[word].ctx, ast.Store):
            yield f"line {first[word].lineno}: {word} is of the element before"


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
    ],
)
def test_another_form_is_seen(loop: str) -> None:
    assert list(strange(ast.parse(f"def f(all, last, count, rest):\n{_indented(loop)}"))) != []


def _indented(text: str) -> str:
    return "".join(f"  {line}\n" for line in text.splitlines())
