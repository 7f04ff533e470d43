"""Signals that are taken over for a while, at whatever moment they come."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from types import FrameType
from typing import Any

import pytest

from protocol.process import signals
from protocol.process.signals import ENDING, heard_by


@pytest.fixture(autouse=True)
def handlers() -> Iterator[dict[int, Any]]:
    """Each raises KeyboardInterrupt, as in the command."""
    before = {number: signal.signal(number, signal.default_int_handler) for number in ENDING}
    yield dict.fromkeys(ENDING, signal.default_int_handler)
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", ENDING)
def test_a_signal_at_any_line_leaves_all_handlers_as_they_were(number: int, handlers: dict[int, Any]) -> None:
    heard, raised = list[int](), list[int]()

    def interrupted_at(moment: int) -> None:
        line, outer = 0, sys.gettrace()

        def trace(frame: FrameType, event: str, _arg: object) -> Any:
            nonlocal line
            if frame.f_code.co_filename != signals.__file__:
                return None
            line += event == "line"
            if line > moment:
                line = -sys.maxsize
                signal.raise_signal(number)
            return trace

        sys.settrace(trace)
        try:
            with heard_by(lambda each, _: heard.append(each)):
                pass
        except KeyboardInterrupt:
            raised.append(number)
        finally:
            sys.settrace(outer)

    def times() -> int:
        return len(heard) + len(raised)

    moments = 0
    while times() == moments:  # it was heard once for every line so far
        interrupted_at(moments)
        assert {each: signal.getsignal(each) for each in ENDING} == handlers, moments
        moments += 1
    assert times() == moments - 1 > 20  # the last was no line any more
    assert heard
    assert raised


def test_what_is_ignored_or_left_to_the_system_is_so_again() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    with heard_by(signal.SIG_IGN):
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_a_handler_that_is_set_inside_stays(handlers: dict[int, Any]) -> None:
    with heard_by(lambda _number, _frame: None):
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    now = {each: signal.getsignal(each) for each in ENDING}
    assert now == handlers | {signal.SIGTERM: signal.SIG_IGN}
