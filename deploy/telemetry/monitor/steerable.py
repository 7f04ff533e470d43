"""A source whose run can be steered: what the live page is served from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from concurrent.futures import Future

from deploy.telemetry.monitor.source import Source
from protocol.requests.goals import GoalOrder, GoalReply
from protocol.requests.steering import Steer


class Steerable(Source, ABC):
    """A `Source` that passes on what its viewers ask for; every method may be called from any thread."""

    @abstractmethod
    def steer(self, steer: Steer) -> None:
        """Ask for a pause, steps or a speed; takes effect soon, and shows in a later snapshot."""

    @abstractmethod
    def order(self, robot: int, order: GoalOrder) -> Future[GoalReply]:
        """Send a robot elsewhere; what is accepted shows in a later snapshot."""

    @abstractmethod
    def halt(self, halt: bool) -> Future[str]:
        """Have every robot stand at once, or release them; the text says why that failed, empty if not."""
