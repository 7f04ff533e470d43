"""Mutants of the kernel: each precondition omitted, and other rules changed. The solver has to find a
counterexample of small numbers to each.
"""

from __future__ import annotations

import re

from tests.interpreted import Edit
from tests.proof.language import SOURCES
from tests.proof.objects import SOURCE
from tests.proof.prove import CASES, Witness, counterexample

_RULES = {"bind": ("introduce", "ask")}

# Preconditions that the invariant does not need, and their reasons.
REDUNDANT = {
    "introduce: the low end comes first": "for the caller",
    "acknowledge: it was granted": "a Command has only adopted regions",
    "read answer: it has seen what was proposed": "an answer has only proposed lines",
    "remove: the disk is there": "for the caller",
    "freeze: the other end stands": "else no place is behind the line",
    "command: a region was adopted": "else nothing is inside",
}


_LIVING, _STATIC = "if living is not None and living.since", "if static is not None and static.end"
_ENDED = "            pair.living = None\n\n    def ack"
_TAKES_OVER = "        elif living and static:\n            living.first = static.first\n"
_COVERED, _UNLESS = "covered = own if end.peer == part else body\n", "            if "
_NEXT = "                continue\n"
_NOTED = "self._geometry.note(disk)\n"
_GRANTED = "disk.held.grant(self.version, region)\n"
_CHANGED = (  # name, rule, source text, and its replacement
    ("a follower adopts what its body does not fit", "adopt", "        if fits:", "        if True:"),
    ("an owner obeys only what it holds", "propose", "self.number += 1", "self.number += 1; self.seen += 1"),
    ("an owner holds the last number answered", "read answer", "= held, seen", "= seen, seen"),
    ("an owner obeys what it held before", "read answer", "                self.held = line",
     "                pass"),
    ("an owner drops open proposals", "read answer", "[each for each in self.open if each[0] > seen]", "[]"),
    ("a proposal is not obeyed", "propose", "self.open.append((self.number, line))", "pass"),
    ("a follower obeys what it held before", "adopt", "self.held_number, self.held = number, line",
     "self.held_number = number"),
    ("a half-plane is not obeyed", "turn", "return [self.half]", "return []"),
    ("an older region is sent", "message", "held.regions[-1]", "held.regions[0]"),
    ("a disk is sent its own place", "message", "place = other.held", "place = disk.held"),
    ("a region that is obeyed is forgotten", "acknowledge", "each[0] >= number", "each[0] > number"),
    ("a part ends bindings of others", "part", "pairs[one.name].pop(other.name, None)",
     "pairs[one.name].clear()"),
    ("the swept body is not recorded", "command", "= body, own, part", "= own, own, part"),
    ("a half-plane is forgotten", "receive", "end.static = listed.place, listed.static",
     "end.half = listed.place, None"),
    ("a first line is not recorded", "answer", "binding.first, binding.since = line,", "binding.since ="),
    ("tied by a binding without a first line", "grant", f"{_LIVING} != NO:", "if living is not None:"),
    ("tied because they were once", "grant", f"        {_LIVING} != NO:",
     f"        if living is None and static is None:\n            return True\n        {_LIVING} != NO:"),
    ("tied by a place of its own", "grant", " and static.end(disk.name).dead == NO", ""),
    ("what is kept towards a place goes on", "grant", f"{_STATIC}(disk.name).dead != NO:", "if False:"),
    ("an ask towards a place goes on", "grant", f"{_LIVING} == NO and living.asked != disk.name:",
     "if False:"),
    ("a fence forgets the line", "fence", "            pair.static = living\n", "            pass\n"),
    ("a fence keeps a binding of two dead ends", "fence", "pair.static = None  # both ends are dead",
     "return"),
    ("a fence keeps an older binding", "fence", "static.since != NO or", "True or"),
    ("a fence drops an older binding", "fence", " or living is None or living.since == NO:", ":"),
    ("what is listed is not taken", "receive", "self.ends[listed.number] = end\n", "pass\n"),
    ("only the newest region is held", "grant", "held.grant(self.version", "held.stand(self.version"),
    ("a region that is granted is not kept", "grant", "self.regions.append((number, region))", "pass"),
    ("a place that is left is kept", "settle", "self.regions = [(number, place)]", "pass"),
    ("all disks have the last place", "restart", "for name, place in places.items()}",
     "for name in places for place in places.values()}"),
    ("a grant is noted before it is held", "grant", f"        {_GRANTED}        {_NOTED}",
     f"        disk.held.granted = self.version\n        {_NOTED}        {_GRANTED}"),
    ("a grant is not noted", "grant", f"region)\n        {_NOTED}", "region)\n"),
    ("a fence is not noted", "fence", f"place)\n            {_NOTED}", "place)\n"),
    ("a settled place is not noted", "settle", f"place)\n        {_NOTED}", "place)\n"),
    ("an announced disk is not noted", "announce", "self._geometry.note(found)", ""),
    ("only what has a place is taken", "receive", "            self.ends[listed.number] = end\n",
     "            if end.place is not None:\n                self.ends[listed.number] = end\n"),
    ("a first line is a half-plane", "freeze", "Follower(first)", "Follower(first); self.half = first"),
    ("a first line beside any other", "freeze", "line in self.kept(end)", "len(self.kept(end)) > 0"),
    ("a line kept towards another disk", "freeze", " and end.peer == asked.peer:", ":"),
    ("a line kept that may be over", "freeze", "end.static and end.peer", "end.peer"),
    ("a line kept that has the place in front", "freeze", 'self.behind(end, line), "freeze',
     'line in self.kept(end) or self.behind(end, line), "freeze'),
    ("a half-plane turns its end round", "turn", "self.half = HALF, half",
     "self.half, self.low = HALF, half, True"),
    ("an adoption ends all bindings", "adopt region", "offered_number, offered\n",
     "offered_number, offered; self.ends = {}\n"),
    ("a smaller body takes the next region", "locate", "= body, own\n",
     "= body, own; self.region = self.offered\n"),
    ("a robot begins with a part", "rejoin", "= body, body, NO", "= body, body, life"),
    ("a fence gives an end to another disk", "fence", "(disk.name).dead = self.version",
     "(disk.name).dead = living.high.disk = self.version"),
    ("an ask takes over an older line", "grant", _ENDED, _ENDED.replace("\n\n", f"\n{_TAKES_OVER}\n")),
    ("all disks have the same bindings", "restart", "{name: {} for name in places}",
     "dict.fromkeys(places, {})"),
    ("only what has no lines is kept to", "command", _COVERED, f"{_COVERED}{_UNLESS}end.lines:\n{_NEXT}"),
    ("a number that is an id ends all", "command", _COVERED,
     f"{_COVERED}{_UNLESS}self.name in self.ends:\n{_NEXT}"),
    ("any part makes a body small", "freeze", "end.peer == self.part", "self.part != NO"),
    ("a message forgets regions", "message", "        held = disk.held\n",
     "        held = disk.held\n        held.acknowledge(held.granted)\n"),
    ("a life begins that is none", "rejoin", "disk.life = self.version", "disk.life = NO"),
    ("what has appeared is not present", "appear", "        disk.phase = PRESENT", "        pass"),
    ("a proposed line has an older one's number", "propose", 'fits the line")\n        self.number',
     'fits the line")\n        return\n        self.number'),
    ("an end is of the disk that was asked", "ask", "End(low.name, low.life", "End(asked, low.life"),
    ("parted disks are present", "part", "_release(one, other)\n", "_release(one, other); other.phase = 2\n"),
    ("a place is absent", "settle", "\n        disk.held.stand", "\n        disk.phase = 1; disk.held.stand"),
    ("the small body keeps off everything", "command", "own if end.peer == part else body", "own"),
)  # fmt: skip


CHANGES = {  # changed rules: cases that execute them, and edits
    name: (rule, [Edit(f"protocol.kernel.{of}", old, new) for of, text in SOURCES.items() if old in text])
    for name, rule, old, new in _CHANGED
}


def preconditions() -> list[str]:
    """Names of all preconditions, as in the source."""
    return list(dict.fromkeys(re.findall(r'"((?:[a-z]+ ?)+: [^"]+)"', "".join(SOURCES.values()))))


def names() -> list[str]:
    """Names of all mutants."""
    return [*preconditions(), *CHANGES]


def refuted(name: str) -> Witness | None:
    """A counterexample to a mutant; None if all claims are proved."""
    rule, edits = CHANGES.get(name, (name.split(":", maxsplit=1)[0], ()))
    SOURCE.read(edits)
    try:
        mine = [case for case in CASES.values() if case.rule.startswith(_RULES.get(rule, (rule,)))]
        return next(filter(None, (counterexample(case, without=name) for case in mine)), None)
    finally:
        SOURCE.read()
