"""Ctrl-C at every line of the launcher's own loop, once the first of two runs has its report."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Iterator
from types import FrameType
from typing import Any, Literal

import pytest

from deploy.library.load import load
from deploy.processes import table
from deploy.processes.row import Exit
from deploy.run import fleet as launcher
from deploy.run.fleet import Fleet
from deploy.run.interruption import counted
from deploy.run.options import RunOptions
from deploy.run.outcome.unjudged import unjudged

Then = Literal["arrives", "dies", "goes on"]
SWAP = load("swap-2")
WORLD = table.Process(table.WORLD, "x:y", (), reports=True, vital=True)
PROMPT = 12  # polls after which a world that is asked to end has ended


class World:
    """Stands for a supervisor with one process, the world; reports run 0 at once. In run 1 it arrives, or
    dies, or goes on until it is asked to end."""

    names = ()

    def __init__(self, then: Then) -> None:
        self._then, self._polls = then, 0
        self._unheard: list[str] = []
        self._up = True

    def poll(self) -> list[Exit]:
        self._polls += 1
        if self._polls == 2:
            self._tell(0, "arrived")
        if self._polls == 4 and self._then == "arrives":
            self._tell(1, "arrived")
        if self._polls == 4 and self._then == "dies":
            self._up = False
            return [Exit(WORLD, -9, expected=False)]
        self._up &= self._polls < PROMPT
        return []

    def _tell(self, run: int, verdict: str) -> None:
        report = unjudged(SWAP, None, 0.0) | {"run_number": run, "verdict": verdict, "reason": "so"}
        self._unheard.append(json.dumps(report))

    def heard(self, _name: str) -> list[str]:
        heard, self._unheard = self._unheard, []
        return heard

    def running(self) -> list[str]:
        return [table.WORLD] if self._up else []

    def signal(self, _name: str, _number: int) -> None:
        self._tell(1, "interrupted")


class Silence:
    """A bus on which nothing is heard; in a run that goes on there is a Ctrl-C meanwhile."""

    def __init__(self, then: Then) -> None:
        self._left = iter([3, 2, 1, 0] if then == "goes on" else [])

    def receive(self, _timeout: float) -> None:
        if next(self._left, None) == 0:
            signal.raise_signal(signal.SIGINT)


class Assembled:
    """How the fleet was put together does not matter here."""

    expired = ""


def interrupted_at(moment: int, then: Then) -> list[dict[str, Any]] | None:
    """What is reported if there is a Ctrl-C at the n-th line; None if there are not that many."""
    fleet = Fleet([SWAP, SWAP], RunOptions("routed"))
    fleet._supervisor = World(then)  # type: ignore[assignment]
    fleet._bus = Silence(then)  # type: ignore[assignment]
    fleet._assembly = Assembled()  # type: ignore[assignment]
    lines, outer = _moments(moment), sys.gettrace()

    def trace(frame: FrameType, event: str, _arg: object) -> Any:
        if frame.f_code.co_filename != launcher.__file__:
            return None
        if event == "line" and fleet._reports.all and next(lines, False):
            signal.raise_signal(signal.SIGINT)
        return trace

    sys.settrace(trace)
    try:
        reports = fleet.execute()
    finally:
        sys.settrace(outer)
    return reports if next(lines, None) is None else None


def _moments(moment: int) -> Iterator[bool]:
    """True for the n-th that is asked for, and no more after it."""
    yield from (number == moment for number in range(moment + 1))


@pytest.mark.parametrize(
    ("then", "verdicts"),
    [
        ("arrives", {"interrupted", "arrived"}),
        ("dies", {"interrupted", "aborted"}),
        ("goes on", {"interrupted"}),
    ],
)
def test_whenever_ctrl_c_comes_every_run_is_reported(then: Then, verdicts: set[str]) -> None:
    moment, seen = 0, set[str]()
    while (reports := interrupted_at(moment, then)) is not None:
        told = [(report["run_number"], report["verdict"]) for report in reports]
        assert told[0] == (0, "arrived"), moment
        assert [run for run, _ in told] == [0, 1], moment
        seen.add(told[1][1])
        moment += 1
    assert moment > 20
    assert seen == verdicts


def test_who_counts_interruptions_keeps_them_from_nobody() -> None:
    heard: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: heard.append(number))
    ignored = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with counted() as interruptions:
            assert interruptions() == 0
            signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGHUP)
            with counted() as nested:
                signal.raise_signal(signal.SIGINT)
            assert (interruptions(), nested(), len(heard)) == (2, 1, 2)
    finally:
        signal.signal(signal.SIGINT, before)
        signal.signal(signal.SIGHUP, ignored)


def test_ctrl_c_that_nobody_looks_at_is_followed_by_one_that_raises() -> None:
    """Where something holds up the loop that counts."""
    with counted() as interruptions:
        for count in (1, 2):
            signal.raise_signal(signal.SIGINT)
            assert interruptions() == count
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


def test_two_ctrl_c_at_once_have_nobody_wait() -> None:
    fleet = Fleet([SWAP, SWAP], RunOptions("routed"))
    fleet._supervisor = World("goes on")  # type: ignore[assignment]
    fleet._assembly = Assembled()  # type: ignore[assignment]

    class Impatient:
        asked = 0

        def receive(self, _timeout: float) -> None:
            self.asked += 1
            if self.asked == 4:
                signal.raise_signal(signal.SIGINT)
                signal.raise_signal(signal.SIGINT)

    fleet._bus = bus = Impatient()  # type: ignore[assignment]
    reports = fleet.execute()
    assert [report["verdict"] for report in reports] == ["arrived", "interrupted"]
    assert bus.asked == 4  # and none while the world would have reported


def test_one_after_that_of_who_watches_has_nobody_wait() -> None:
    fleet = Fleet([SWAP, SWAP], RunOptions("routed"))
    fleet._supervisor = World("goes on")  # type: ignore[assignment]
    fleet._assembly = Assembled()  # type: ignore[assignment]

    class Interrupted:
        asked = 0

        def receive(self, _timeout: float) -> None:
            self.asked += 1
            if self.asked == 4:
                raise KeyboardInterrupt
            if self.asked == 6:
                signal.raise_signal(signal.SIGINT)

    fleet._bus = bus = Interrupted()  # type: ignore[assignment]
    reports = fleet.execute()
    assert [report["verdict"] for report in reports] == ["arrived", "interrupted"]
    assert bus.asked == 6 < PROMPT - 1
