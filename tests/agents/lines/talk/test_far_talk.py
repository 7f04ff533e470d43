"""Letters say what has to be said, and again only what should have been answered."""

from __future__ import annotations

import numpy as np

from agents.lines.ends import Owner
from agents.lines.line import Line
from agents.lines.placement import Disk
from agents.lines.robot_pair import RobotPair
from agents.lines.talk.far import FarTalk
from agents.peers.far import FarPicture
from protocol.messages import Answer, Proposal, Summary
from world.coordinator.interest import runs

RADIUS = 0.1
ME = Disk(0.0, 0.0, RADIUS)
THERE = (1.0, 0.0)


def picture() -> FarPicture:
    places, gammas = np.array([THERE], dtype="<f4"), np.zeros(1, dtype="<f4")
    return FarPicture(Summary(0, runs([2]), places.tobytes(), gammas.tobytes()), {2: RADIUS})


def talking(*, owns: bool) -> tuple[FarTalk, RobotPair]:
    """Of a pair whose line is no longer in the middle."""
    line = Line(1.0, 0.0, 0.2) if owns else Line(-1.0, 0.0, -0.2)
    pair = RobotPair(
        2 if owns else 1, 1, owns=owns, own_radius=RADIUS, radius=RADIUS, initial=line, peer_incarnation=1
    )
    return FarTalk(urgent=0.3), pair


def said(talk: FarTalk, ticks: int) -> list[tuple[tuple[Proposal, ...], tuple[Answer, ...]]]:
    return [talk.entries(ME, lambda _: True) for _ in range(ticks)]


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
