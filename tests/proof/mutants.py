"""Every precondition of the kernel left out, and every other rule changed: the solver has to object, with a
state of small numbers in which the rule breaks a conjunct.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from tests.interpreted import Edit
from tests.proof import steps
from tests.proof.prove import Example, counterexample

_KERNEL = Path(__file__).resolve().parents[2] / "protocol" / "kernel"
_LEDGER, _PAIR, _ROBOT = (f"protocol.kernel.{name}" for name in ("ledger", "pair", "robot"))
_RULES = {"bind": ("introduce", "ask"), "answer": ("answer",)}

# Preconditions that are not needed for the invariant.
HARMLESS = {
    "introduce: the low end comes first": "for the caller",
    "acknowledge: it was granted": "a Command says only what was adopted",
    "read answer: it has seen what was proposed": "an answer says only what was proposed",
    "remove: the disk is there": "for the caller",
    "freeze: the other end stands": "else no place is behind the line",
    "command: a region was adopted": "else nothing is inside",
}


class Change(NamedTuple):
    """A rule that reads otherwise."""

    name: str
    rules: tuple[str, ...]
    edit: Edit


CHANGES = (
    Change(
        "a follower adopts what its body does not fit",
        ("adopt",),
        Edit(_PAIR, "        if fits:\n", "        if True:\n"),
    ),
    Change(
        "an owner obeys only what it holds",
        ("propose",),
        Edit(
            _PAIR, "        self.number += 1\n", "        self.number += 1\n        self.seen = self.number\n"
        ),
    ),
    Change(
        "an owner holds the last number answered",
        ("read answer",),
        Edit(_PAIR, "self.held_number, self.seen = held, seen", "self.held_number, self.seen = seen, seen"),
    ),
    Change(
        "tied by a binding that is not told",
        ("grant",),
        Edit(_LEDGER, "if living is not None and living.told != NO:", "if living is not None:"),
    ),
    Change(
        "tied by a place of its own",
        ("grant",),
        Edit(
            _LEDGER,
            "static.told != NO and static.end(disk.name).dead == NO",
            "static.told != NO",
        ),
    ),
    Change(
        "what was kept towards a place goes on",
        ("grant",),
        Edit(
            _LEDGER,
            "        if static is not None and static.end(disk.name).dead != NO:\n"
            "            pair.static = None\n",
            "",
        ),
    ),
    Change(
        "an ask of a peer towards a place goes on",
        ("grant",),
        Edit(
            _LEDGER,
            "        if living is not None and living.told == NO and living.asked != disk.name:\n"
            "            pair.living = None\n",
            "",
        ),
    ),
    Change(
        "a fence forgets the line",
        ("fence",),
        Edit(_LEDGER, "            pair.static = living\n", "            pass\n"),
    ),
    Change(
        "a fence keeps a binding of two dead ends",
        ("fence",),
        Edit(_LEDGER, "                pair.static = None  # both ends are dead", "                return"),
    ),
    Change(
        "a fence keeps the older binding though its first line is not told",
        ("fence",),
        Edit(_LEDGER, "elif not moved and static.told != NO:", "elif not moved:"),
    ),
    Change(
        "what is not listed is kept, and what is new is not taken",
        ("hear",),
        Edit(_ROBOT, "            self.bound[listed.number] = bound\n", "            pass\n"),
    ),
    Change(
        "a region is held from the newest acknowledged on only",
        ("grant",),
        Edit(
            _LEDGER,
            "        disk.held.grant(self.version, region)\n",
            "        disk.held.stand(self.version, region)\n",
        ),
    ),
    *[
        Change(
            f"a {rule} is not noted",
            (rule,),
            Edit(_LEDGER, f"        {change}\n{indent}self._geometry.note({disk})\n", f"        {change}\n"),
        )
        for rule, change, indent, disk in (
            ("grant", "disk.held.grant(self.version, region)", " " * 8, "disk"),
            ("fence", "    disk.held.stand(self.version, place)", " " * 12, "disk"),
            ("announce", "self.pairs[name] = {}", " " * 8, "found"),
        )
    ],
    Change(
        "a robot that reaches keeps off everything with the small body",
        ("command",),
        Edit(_ROBOT, "covered = own if bound.peer == part else body", "covered = own"),
    ),
)


def preconditions() -> list[str]:
    """Every precondition by name, as the source has it."""
    source = "".join((_KERNEL / f"{name}.py").read_text() for name in ("ledger", "pair", "robot"))
    return list(dict.fromkeys(re.findall(r'"((?:[a-z]+ ?)+: [^"]+)"', source)))


def names() -> list[str]:
    """Every mutant by name."""
    return [*preconditions(), *[change.name for change in CHANGES]]


class Refutation(NamedTuple):
    """A conjunct that a rule breaks, and a state in which it does."""

    rule: str
    conjunct: str
    example: Example


def refute(rules: tuple[str, ...], without: str = "") -> Refutation | None:
    """What one of these rules breaks; None if they keep everything."""
    for case in steps.cases():
        if case.rule.startswith(rules):
            found = counterexample(case, without)
            if found is not None:
                return Refutation(case.rule, *found)
    return None


def refute_without(precondition: str) -> Refutation | None:
    """What breaks if a precondition is left out."""
    rule = precondition.split(":", maxsplit=1)[0]
    return refute(_RULES.get(rule, (rule,)), precondition)


def refute_changed(change: Change) -> Refutation | None:
    """What breaks if a rule is changed."""
    steps.load((change.edit,))
    try:
        return refute(change.rules)
    finally:
        steps.load()
