"""Letters say what has to be said, and again only what should have been answered."""

from __future__ import annotations

import numpy as np
import pytest

from agents.lines.ends import Owner
from agents.lines.line import Line
from agents.lines.negotiation.far import FarNegotiation
from agents.lines.placement import Disk
from agents.lines.robot_pair import RobotPair
from agents.peers.far import FarPicture, places_of
from agents.peers.state import PeerState, from_afar
from protocol.messages import Answer, Letter, Member, Proposal, Summary
from world.coordinator.crowd.interest import runs

RADIUS = 0.1
ME = Disk(0.0, 0.0, RADIUS)
THERE = (1.0, 0.0)


def picture() -> FarPicture:
    places, gammas = np.array([THERE], dtype="<f4"), np.zeros(1, dtype="<f4")
    summary = Summary(0, runs([2]), places.tobytes(), gammas.tobytes(), gammas.tobytes())
    return FarPicture(places_of(summary), {2: RADIUS})


def talking(*, owns: bool) -> tuple[FarNegotiation, RobotPair]:
    """Of a pair whose line is no longer in the middle."""
    line = Line(1.0, 0.0, 0.2) if owns else Line(-1.0, 0.0, -0.2)
    pair = RobotPair(
        2 if owns else 1, 1, owns=owns, own_radius=RADIUS, radius=RADIUS, initial=line, peer_incarnation=1
    )
    return FarNegotiation(urgent=0.3), pair


def said(talk: FarNegotiation, ticks: int) -> list[tuple[tuple[Proposal, ...], tuple[Answer, ...]]]:
    return [talk.entries(ME, lambda _: True) for _ in range(ticks)]


def spoken(robot: int, incarnation: int) -> PeerState:
    return from_afar(2, Letter(robot, incarnation, 0), RADIUS)


def test_an_offer_is_repeated_once_its_answer_could_be_there() -> None:
    talk, pair = talking(owns=True)
    pair.end.accept(1)
    talk.survey(picture(), ME, [pair])
    offers = [len(proposals) for proposals, _ in said(talk, 5)]
    assert offers == [1, 0, 1, 0, 1]
    assert isinstance(pair.end, Owner)
    pair.end.on_answer(1, 1, 1, 1)
    pair.renew()
    assert said(talk, 4) == [((), ())] * 4


def test_who_was_never_heard_is_asked_first_and_as_often() -> None:
    talk, pair = talking(owns=True)
    talk.survey(picture(), ME, [pair])
    assert [len(answers) for _, answers in said(talk, 4)] == [1, 0, 1, 0]
    pair.end.accept(1)
    assert [len(proposals) for proposals, _ in said(talk, 2)] == [1, 0]


def test_a_follower_answers_once_whatever_it_is_asked() -> None:
    talk, pair = talking(owns=False)
    for _ in range(2):
        pair.answers_left = 1
        talk.take_up(pair)
        assert [len(answers) for _, answers in said(talk, 4)] == [1, 0, 0, 0]


def test_nothing_is_said_by_letter_to_who_came_near() -> None:
    talk, pair = talking(owns=True)
    talk.survey(picture(), ME, [pair])
    said(talk, 1)
    talk.drop(frozenset({2}))
    assert said(talk, 3) == [((), ())] * 3


@pytest.mark.parametrize("owns", [False, True])
def test_who_stands_is_not_written_to_until_it_lives_again_and_speaks(owns: bool) -> None:
    talk, pair = talking(owns=owns)
    pair.on_member(Member(pair.peer, 1, "standing", RADIUS, THERE))
    assert pair.keeps_clear
    talk.take_up(pair)
    assert said(talk, 4) == [((), ())] * 4
    pair.on_member(Member(pair.peer, 2, "live", RADIUS))
    talk.take_up(pair)
    assert said(talk, 4) == [((), ())] * 4
    pair.accept(spoken(pair.peer, 2))
    talk.take_up(pair)
    talk.survey(picture(), ME, [])
    assert any(proposals or answers for proposals, answers in said(talk, 1))


def test_nobody_asks_for_an_answer_of_one_that_is_gone() -> None:
    talk, pair = talking(owns=True)
    talk.survey(picture(), ME, [pair])
    assert [len(answers) for _, answers in said(talk, 2)] == [1, 0]
    pair.on_member(Member(2, 1, "gone", RADIUS))
    assert said(talk, 4) == [((), ())] * 4
