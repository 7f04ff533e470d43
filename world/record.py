"""The record of a run: everything that is measured of the truth, tick by tick."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from protocol.messages import Truth, Vector
from protocol.scenario import Scenario
from world.clearance import Disks, Plane, gaps
from world.contacts import Contacts
from world.phi import NavigationFunction
from world.trajectory import TrajectoryDigest

_RISE = 1e-12  # an increase of phi below this is rounding


class Record:
    """Clearance, contacts, phi and digest of a trajectory.

    Attributes:
        truth: the newest configuration.
        plane: its positions as complex numbers, shape (p,), m.
        clearance: smallest gap so far, over continuous time, m.
        first_phi: phi at tick 0.
        increases: number of ticks in which phi rose.
        contacts: overlaps so far.
    """

    def __init__(self, scenario: Scenario, positions: Sequence[Vector]) -> None:
        self._disks = Disks(scenario)
        self._phi = NavigationFunction(scenario, self._disks)
        self._digest = TrajectoryDigest(self._disks.ids)
        self.contacts = Contacts(self._disks)
        self.plane = as_plane(positions)
        self.clearance = float(gaps(self._disks, self.plane, self.plane).min())
        self.first_phi = self._phi(self.plane)
        self.increases = 0
        self.truth = self._note(0, positions, self.clearance, self.first_phi)

    def add(self, tick: int, positions: Sequence[Vector]) -> Truth:
        """The configuration at the start of `tick`, reached by straight motion since the one before."""
        before, self.plane = self.plane, as_plane(positions)
        during = gaps(self._disks, before, self.plane)
        self.contacts.add(tick - 1, during, before, self.plane)
        clearance, phi = float(during.min()), self._phi(self.plane)
        self.clearance = min(self.clearance, clearance)
        self.increases += phi > self.truth.phi + _RISE
        self.truth = self._note(tick, positions, clearance, phi)
        return self.truth

    def _note(self, tick: int, positions: Sequence[Vector], clearance: float, phi: float) -> Truth:
        self._digest.add(tick, positions)
        return Truth(tick, self._disks.ids, tuple(positions), clearance, phi)

    def sha256(self) -> str:
        """Digest of the trajectory so far."""
        return self._digest.hexdigest()


def as_plane(positions: Sequence[Vector]) -> Plane:
    """Positions as complex numbers x + iy."""
    return np.array([complex(x, y) for x, y in positions])
