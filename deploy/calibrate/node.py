"""The driver of a square on a bus."""

from __future__ import annotations

import time

from deploy.calibrate.square import Driver
from protocol.bus.bus import Bus, Event, Sample
from protocol.errors import BusError


class Calibration:
    """See `protocol.bus.bus.Node`.

    Args:
        bus: a connection of its own.
        driver: what is driven.
        wait: s in which odometry and a pose have to come.

    Raises:
        BusError: they do not; says which is missing.
        MessageError: what comes is no ROS 2 message, or of another type.
    """

    def __init__(self, bus: Bus, driver: Driver, wait: float) -> None:
        self._driver = driver
        self._tell = bus.foreign(driver.tells)
        self._given_up = time.monotonic() + wait
        bus.subscribe(*driver.keys)

    @property
    def finished(self) -> bool:
        """Whether the square is driven."""
        return self._driver.finished

    @property
    def deadline(self) -> float:
        """When `wake` wants to be called next, s, monotonic."""
        return self._driver.due

    def handle(self, event: Event) -> None:
        """Something arrived."""
        if isinstance(event, Sample):
            self._driver.hear(event.key, event.payload, time.monotonic())

    def wake(self, now: float) -> None:
        """Tell the base what it is to do by now."""
        missing = self._driver.waits_for
        if missing and now > self._given_up:
            raise BusError(
                f"nothing came under {missing}: does the bridge run, with that namespace, on the same router?"
            )
        for payload in self._driver.wake(now):
            self._tell(payload)
