"""The kernel is in its subset of Python (`tests/proof/language.py`); changes that leave it are refused."""

from __future__ import annotations

import re
from contextlib import nullcontext

import pytest

from tests.interpreted import interpreted
from tests.proof.language import SOURCES, Kernel


def violations(old: str = "", new: str = "") -> list[str]:
    """Violations in the kernel, or with a replacement in it."""
    (name, *_) = [name for name, text in SOURCES.items() if old in text]
    return list(Kernel(SOURCES | {name: SOURCES[name].replace(old, new, 1)}).violations())


def test_the_kernel_is_in_the_subset() -> None:
    assert violations() == []
    assert not re.search("# *(type|mypy):", "".join(SOURCES.values())), "mypy looks at all of it"


REFUSED = {  # text of the kernel, and continuations that are refused
    "and not self.tied(disk, other)": [
        " and other.name != 7", " and other.name < other.life", " and NO == other.life > other.name",
        " and other.life is not NO", " and other.name.__class__ != other.phase.__class__", " and self.pairs",
        " and self.disks[PRESENT].still", " and self.pairs[name] != self.pairs[disk.name]", " and __spec__",
        " and require.__doc__ is None", " and (lambda: begins)()", " and other.held.regions[0][1] == region",
        " and (still := begins)", " and disk.still == begins", " and self.announce(name, region).still",
    ],
    "\n        disk.life = self.version": [
        "; Pair.since = disk", "; disk.since = self.version", "; disk.held.regions = []", "; made = self",
        "; self.version /= 1", "; self.version += 1.0", "; del self.disks[NO]", "; self.disks[self] = disk",
        "; require(disk.still, 'late: still')", "; require.since = disk", "; pass",
        "; still = self._geometry.apart(disk.held, disk.held)",
    ],
    "\n            self._end(pair, disk)": [
        "; disk.still = True", "; self.version += 1", "; moved = pair.static is None", "; self.rejoin(disk)",
        "; break",
    ],
    'disk.held), "appear: apart from others, or tied")': ["; require(disk.still, 'appear: still')"],
    '"part: what they hold is apart")': [
        "\n        for pair in self.pairs[one.name].values():\n            disk = one\n"
        "            require(self._geometry.apart(other.held, disk.held), 'part: too')",
    ],
    "            pair.static = binding": ["\n        for disk in self.disks.values(): self._end(pair, disk)"],
    "\n        living, static = pair.living, pair.static": ["; disk.still = True", "; static = self.pairs"],
    "\n            end = known.get(listed.number)": ["; known = self.ends", "; listed = end"],
    "\n                found.extend(end.obeyed)": ["; asked = found[0]", "; found = end.obeyed"],
    "\n        held = disk.held": ["; listed = held.regions; listed.append(NO)"], "import Generic": [", sys"],
    " if other.still else None": ["; found = other.held; found.acknowledge(NO)"], "name: int": [" | L"],
    "\n        self.since = NO": ["; self.hidden = NO"], "self.still = True": ["; held.stand(NO, held)"],
    "class Pair(Generic[L]": [", list", " and dict"], "NO: Final = 0": [" - 7"],
    'R = TypeVar("R")': [" and []"], "    if not holds": [" and what"],
    "\n    def ": ["__getattr__", "kept(self): pass\n    def ", "popitem(self): return\n    def "],
    "    @property\n": ["    def known(self) -> None:\n        require(self.low, 'read')\n    @property\n"],
    "pop(one.name, None)": ["; one.held.acknowledge(NO)"], "= living": ["; pair.static = Pair()"],
    "@mypyc_attr(allow_interpreted_subclasses=True)\n": [
        "class Pair:\n    'two'\n    def __init__(self): self.living = self.static = None\n"
        "@mypyc_attr(allow_interpreted_subclasses=True)\n",
    ],
}  # fmt: skip
CASES = [(words, more) for words, others in REFUSED.items() for more in others]


@pytest.mark.parametrize(("words", "more"), CASES)
def test_a_continuation_outside_the_subset_is_refused(words: str, more: str) -> None:
    assert violations(words, f"{words}{more}") != []


@pytest.mark.parametrize("holds", [True, False])
def test_require_raises_if_a_precondition_does_not_hold(holds: bool) -> None:
    (records,) = interpreted("protocol.kernel.records")
    with nullcontext() if holds else pytest.raises(records.RefusedError, match="rule: what"):
        records.require(holds, "rule: what")
