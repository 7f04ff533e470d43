"""Which worlds make a robot's process ask to join again, and when."""

import time
from types import SimpleNamespace

import pytest

from agents.shell.world_session import PATIENCE, WorldSession
from deploy.library.load import load
from protocol.bus.local import LocalNetwork
from protocol.errors import BusError, JoinError
from protocol.joining import Admission, Finished, JoinReply, OtherRun, Refusal, Wait, encode_reply
from protocol.keys import robot_key, session_of

OWN, NEXT = 7, 8  # epochs
SWAP = load("swap-2")


@pytest.fixture
def session() -> WorldSession:
    made = WorldSession(LocalNetwork().connect(), "run", 1, 20.0, lambda _: None)
    made.admitted(admission(OWN))
    return made


@pytest.mark.parametrize(
    ("tokens", "back"),
    [
        pytest.param([(NEXT, True)], True, id="its own died before its token was seen"),
        pytest.param([(OWN, True), (NEXT, True)], False, id="another is beside its own"),
        pytest.param([(OWN, True), (OWN, False)], False, id="its own disappears"),
        pytest.param([(OWN, True), (OWN, False), (NEXT, False)], False, id="and another does"),
        pytest.param([(OWN, True), (OWN, False), (OWN, True)], True, id="and returns"),
    ],
)
def test_a_world_that_takes_the_place_of_its_own_is_asked(
    session: WorldSession, tokens: list[tuple[int, bool]], back: bool
) -> None:
    for epoch, alive in tokens:
        session.on_token(session_of(epoch), alive=alive)
    assert session.back is back
    if tokens[-1] == (OWN, True):
        assert session.check(time.monotonic() + 100.0), "it is silent, not gone"


@pytest.mark.parametrize("gone", [False, True])
def test_a_silent_world_is_asked_once_a_while(session: WorldSession, gone: bool) -> None:
    session.on_token(session_of(OWN), alive=True)
    if gone:  # its successor's token was missed
        session.on_token(session_of(OWN), alive=False)
    now = time.monotonic()
    assert not session.check(now + 0.5 * PATIENCE)
    assert session.check(now + 1.5 * PATIENCE)
    assert not session.check(now + 2.0 * PATIENCE)
    assert session.check(now + 3.0 * PATIENCE)


def test_a_world_that_says_ticks_is_there(session: WorldSession) -> None:
    session.on_token(session_of(OWN), alive=True)
    session.on_token(session_of(OWN), alive=False)
    session.on_tick()
    session.on_token(session_of(NEXT), alive=False)  # another one's
    assert session.check(time.monotonic() + 100.0), "it is silent, not gone"


@pytest.mark.parametrize(("epoch", "way"), [(OWN, "is back"), (NEXT, "has been started again")])
def test_the_operator_hears_once_of_a_world_that_is_gone_and_of_the_next(
    session: WorldSession, epoch: int, way: str
) -> None:
    said, now = list[str](), time.monotonic()
    session._warn = said.append
    session.over()  # which may be repeated by a successor
    session.on_token(session_of(OWN), alive=False)
    for later, times in (1.9, 0), (2.1, 1), (59.0, 1):
        session.check(now + later)
        assert said == ["the world of run 'run' is gone; the robot stands still"] * times
    with pytest.raises(BusError, match="has been gone for 60 s"):
        session.check(now + 61.0)
    for alive in True, False, True:
        session.on_token(session_of(epoch), alive=alive)
    assert said[1:] == [f"the world of run 'run' {way}"]


def test_a_process_gives_up_when_it_is_refused_five_times_in_a_row(session: WorldSession) -> None:
    refused = [Refusal("taken")] * 4
    replies, bus = [*refused, Wait(0.2, "paused"), *refused, *refused], session._bus.network.connect()
    bus.serve(robot_key("run", 1, "join"))
    bus.node = SimpleNamespace(handle=lambda query: query.reply(encode_reply(replies.pop(0))))
    session.heard -= 2.0 * PATIENCE
    assert [session.ask(None) for _ in range(9)] == [*[None] * 4, Wait(0.2, "paused"), *[None] * 4]
    assert not session.check(time.monotonic()), "it is not silent"
    with pytest.raises(JoinError, match="taken"):
        session.ask(None)


def answered(*replies: JoinReply, epoch: int = OWN) -> JoinReply | None:
    """What a process that the coordinator `epoch` admitted makes of the replies of several worlds."""
    network = LocalNetwork()
    for reply in replies:
        bus = network.connect()
        bus.serve(robot_key("run", 1, "join"))
        bus.node = SimpleNamespace(handle=lambda query, reply=reply: query.reply(encode_reply(reply)))
    session = WorldSession(network.connect(), "run", 1, 20.0, lambda _: None)
    if epoch:
        session.admitted(admission(epoch))
    return session.ask(None, begun=True)


def admission(epoch: int) -> Admission:
    return Admission(1, True, SWAP, grace=60.0, epoch=epoch)


def test_of_two_worlds_its_own_is_believed() -> None:
    worlds = admission(OWN), admission(NEXT)
    assert answered(*worlds, epoch=0) is None, "it knows neither"
    assert answered(*worlds) == worlds[0] == answered(Wait(0.2, "paused"), *worlds)
    assert answered(*worlds, epoch=NEXT) == worlds[1]


@pytest.mark.parametrize("reply", [admission(NEXT), Wait(0.2, "paused"), Finished("arrived")])
def test_worlds_of_other_runs_do_not_keep_it_from_the_next_of_its_own(reply: JoinReply) -> None:
    assert answered(OtherRun(), reply, OtherRun()) == reply
    assert answered(OtherRun(), OtherRun()) is None, "its own may return"


@pytest.mark.parametrize(("wait", "grace"), [(1.0, 0.0), (20.0, 60.0), (20.0, 0.0)])
def test_it_waits_for_its_own_world_and_no_longer_than_that_beside_another_run(
    wait: float, grace: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    network, now = LocalNetwork(), [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    for bus in network.connect(), network.connect():
        bus.serve(robot_key("run", 1, "join"))
        bus.node = SimpleNamespace(handle=lambda query: query.reply(encode_reply(OtherRun())))
    session = WorldSession(network.connect(), "run", 1, wait, lambda _: None)
    session.admitted(Admission(1, True, SWAP, grace=grace, epoch=OWN))
    session.on_token(session_of(OWN), alive=False)
    session.check(99.9 + max(PATIENCE, wait, grace))
    with pytest.raises(BusError, match="has been gone for"):
        session.check(100.1 + max(PATIENCE, wait, grace))
    bearable = max(PATIENCE, grace)
    for now[0] in (101.0, 100.9 + bearable):
        assert session.ask(None, begun=True) is None
    now[0] = 101.1 + bearable
    with pytest.raises(BusError, match="another run has the name"):
        session.ask(None, begun=True)


def test_a_lost_question_is_asked_again_before_the_world_gives_it_up(session: WorldSession) -> None:
    session.heard -= 1.1 * PATIENCE
    assert session.check(time.monotonic())
    assert session.ask(None) is None, "no world is on this bus"
    assert not session.check(time.monotonic())
    assert session.check(time.monotonic() + 0.3 * PATIENCE)
