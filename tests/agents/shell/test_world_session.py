"""Which worlds make a robot's process ask to join again, and when."""

import time

import pytest

from agents.shell.world_session import PATIENCE, WorldSession
from deploy.library.load import load
from protocol.bus.local import LocalNetwork
from protocol.joining import Admission
from protocol.keys import session_of

OWN, NEXT = 7, 8  # epochs


@pytest.fixture
def session() -> WorldSession:
    made = WorldSession(LocalNetwork().connect(), "run", 1, 20.0, lambda _: None)
    made.admitted(Admission(1, True, load("swap-2"), away=60.0, epoch=OWN))
    return made


def test_a_world_that_died_before_its_token_was_seen_is_replaced(session: WorldSession) -> None:
    session.on_token(session_of(NEXT), alive=True)
    assert session.back


def test_another_world_beside_its_own_is_not_asked(session: WorldSession) -> None:
    session.on_token(session_of(OWN), alive=True)
    session.on_token(session_of(NEXT), alive=True)
    assert not session.back


def test_its_own_disappears_and_returns(session: WorldSession) -> None:
    session.on_token(session_of(OWN), alive=True)
    session.on_token(session_of(OWN), alive=False)
    assert not session.back
    session.on_token(session_of(OWN), alive=True)
    assert session.back


def test_a_silent_world_is_asked(session: WorldSession) -> None:
    session.on_token(session_of(OWN), alive=True)
    now = time.monotonic()
    session.check(now + 0.5 * PATIENCE)
    assert not session.back
    session.check(now + 1.5 * PATIENCE)
    assert session.back
