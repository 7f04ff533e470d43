"""An external base on the bus: its velocities, and reports of its faults."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from agents.bases.base import misplaced
from agents.bases.dialects import Topic
from agents.robot import Robot
from agents.shell.ros_link import RosLink
from protocol.messages import Command, Sense, Tick, Vector

if TYPE_CHECKING:
    from agents.bases.ros2 import Ros2Base

_NUMBERS: Final = re.compile(r"[-.0-9]+")  # of a fault, which vary with every measurement
_BOOT = getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC)


def since_boot() -> float:
    """Time, s, that passes while the computer is suspended, too, if its system has such a clock."""
    return time.clock_gettime(_BOOT)


class AttachedBase:
    """One base, for one life of its robot after another.

    Its lease and the age of odometry use time that includes suspension; deadlines use monotonic time.
    """

    def __init__(self, base: Ros2Base, link: RosLink, warn: Callable[[str], None]) -> None:
        self.topics = base.topics
        self.trouble = ""  # the fault reported last; "" if none
        self.in_place = False  # whether it was free of faults, with the robot at a valid start, at least once
        self._base, self._warn = base, warn
        link.subscribe(*base.topics)
        self._publish = link.publisher(base.drives)
        self._others: set[str] = set()  # tokens of other processes that drive this base
        self._own = link.claim(base.drives)

    @property
    def due(self) -> float:
        """Time of the next `on_timer`, s, monotonic."""
        return time.monotonic() + self._base.due - since_boot()

    @property
    def heading(self) -> float:
        """Heading of the robot in the map, rad; 0 if unknown."""
        return self._base.senses.heading()

    def on_message(self, topic: Topic, payload: bytes) -> Vector | None:
        """Receive a message of one of its topics; as `Ros2Base.on_message`."""
        return self._base.on_message(topic, payload, since_boot())

    def on_driver(self, token: str, alive: bool) -> None:
        """A token of a process that drives this base came or went. With several, the robot stands."""
        if token == self._own:
            return
        (self._others.add if alive else self._others.discard)(token)
        self._base.share(bool(self._others))

    def begin(self, core: Robot, tick: Tick) -> Sense | None:
        """Odometry and measurement as a tick begins; resets the core's estimate after a fault."""
        sense, senses = self._base.begin(tick, since_boot()), self._base.senses
        if senses.take_reset():
            core.reset_estimate()
        elif core.lost and not senses.fault:
            senses.invalidate(core.note)
        return sense

    def obey(self, command: Command) -> None:
        """Execute the Command of the newest tick, before it is sent."""
        self._publish(self._base.obey(command, since_boot()))

    def stand(self, core: Robot, *, founded: bool) -> None:
        """Brake at once, outside of a tick. The parameters are those of `on_timer`."""
        self._publish(self._base.stand(since_boot()))
        self.on_timer(core, founded=founded)

    def on_timer(self, core: Robot, *, founded: bool) -> None:
        """Publish the velocity that is due, and report faults of the base.

        Args:
            founded: whether the run had begun when the robot was admitted: then it starts at its disk.
        """
        self._publish(self._base.on_timer(since_boot()))
        trouble = self._base.senses.fault
        if not self.in_place and not trouble:
            known = self._base.senses.place()
            if known is not None and not founded:
                trouble = misplaced(core.scenario, core.robot, *known)
            self.in_place = not trouble
        is_news = _NUMBERS.sub("", trouble) != _NUMBERS.sub("", self.trouble)
        self.trouble = trouble
        if is_news:
            self._warn(f"{trouble}; stands" if trouble else "base and localisation work again")
