"""The pair's invariant in every reachable state of a small model, and proof that the search would notice."""

from __future__ import annotations

import pytest
from small_model import Bounds, Follower, Owner, search


@pytest.mark.parametrize(
    ("bounds", "at_least"),
    [
        (Bounds(1, 1, proposals=3), 500),
        (Bounds(1, 1, proposals=4, outstanding=2), 10_000),
        (Bounds(1, 3, proposals=2), 3_000),
        (Bounds(1, 2, proposals=3, outstanding=2), 10_000),
        (Bounds(2, 1, proposals=2), 5_000),
        pytest.param(Bounds(2, 2, proposals=1, fences=2), 100_000, marks=pytest.mark.slow),
        (Bounds(1, 2, proposals=2, fences=1), 5_000),
        (Bounds(2, 1, proposals=1, fences=2), 5_000),
        (Bounds(1, 2, proposals=2, fences=1, initial=True), 5_000),
        (Bounds(2, 1, proposals=1, fences=1, initial=True), 1_000),
        pytest.param(Bounds(2, 2, proposals=1, fences=1, initial=True), 20_000, marks=pytest.mark.slow),
        pytest.param(Bounds(2, 1, proposals=2, fences=1), 50_000, marks=pytest.mark.slow),
        pytest.param(Bounds(2, 2, proposals=2), 90_000, marks=pytest.mark.slow),
    ],
)
def test_no_order_of_events_breaks_the_invariant(bounds: Bounds, at_least: int) -> None:
    result = search(bounds)
    assert result.counterexample is None
    assert result.visited >= at_least


class ForgetsProposal(Owner):
    """Drops the unanswered proposal when the follower lives anew."""

    def meet(self, peer_life: int) -> bool:
        if peer_life > self.peer_life:
            self.proposed = {}
        return super().meet(peer_life)


class OffersToStrangers(Owner):
    """Offers a line to a life that it only expects."""

    def bury(self, life: int) -> None:
        super().bury(life)
        self.met = True


class ForgetsHeld(Owner):
    """Drops the held line when the follower lives anew."""

    def meet(self, peer_life: int) -> bool:
        if peer_life > self.peer_life:
            self.held = None
        return super().meet(peer_life)


class DropsAtOnce(Owner):
    """Obeys only its newest proposal."""

    def propose(self, line: object) -> int:
        self.held = None
        return super().propose(line)  # type: ignore[arg-type]  # the signature of the base class


class TakesOldAnswers(Owner):
    """Reads an answer to an earlier life as one to its own."""

    def hear(self, peer_life: int, life: int, held: int, seen: int) -> bool:
        return super().hear(peer_life, self.life, held, seen)


class ReadyTooEarly(Owner):
    """Takes an unanswered proposal for a line."""

    def propose(self, line: object) -> int:
        self.agreed = True
        return super().propose(line)  # type: ignore[arg-type]  # the signature of the base class


class TakesOldOffers(Follower):
    """Adopts a number that it has passed over."""

    def hear(self, *offer: object) -> bool:
        self.seen = 0
        return super().hear(*offer)  # type: ignore[arg-type]  # the signature of the base class


class TakesOffersToOthers(Follower):
    """Adopts what was offered to an earlier life of its own."""

    def hear(self, peer_life: int, life: int, *offer: object) -> bool:
        return super().hear(peer_life, self.life, *offer)  # type: ignore[arg-type]  # as above


class TakesDeadOwners(Follower):
    """Adopts what an earlier life of the owner offered."""

    def hear(self, peer_life: int, *offer: object) -> bool:
        return super().hear(max(peer_life, self.peer_life), *offer)  # type: ignore[arg-type]  # as above


class AdoptsBlindly(Follower):
    """Adopts a line that its disk does not satisfy."""

    def hear(self, peer_life: int, life: int, number: int, line: object, fits: object) -> bool:
        return super().hear(peer_life, life, number, line, lambda _: True)  # type: ignore[arg-type]  # as above


@pytest.mark.parametrize(
    "owner",
    [ForgetsProposal, ForgetsHeld, DropsAtOnce, TakesOldAnswers, ReadyTooEarly],
)
def test_search_finds_a_broken_owner(owner: type[Owner]) -> None:
    assert search(Bounds(2, 2, proposals=2), owner=owner).counterexample is not None


def test_search_finds_an_owner_that_trusts_a_fence_too_far() -> None:
    assert search(Bounds(2, 2, proposals=1, fences=1), owner=OffersToStrangers).counterexample is not None


@pytest.mark.parametrize("follower", [TakesOldOffers, TakesOffersToOthers, TakesDeadOwners, AdoptsBlindly])
def test_search_finds_a_broken_follower(follower: type[Follower]) -> None:
    assert search(Bounds(2, 2, proposals=2), follower=follower).counterexample is not None
