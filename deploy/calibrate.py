"""Calibration of a base: drive a square, and compare commands, odometry and poses.

After the last side nothing is sent, so that the base's own timeout is measured.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from agents.bases import dialects as ros
from agents.bases.dialects import Topic
from agents.bases.ros_messages import (
    Odometry,
    Pose,
    StampedPose,
    StampedVelocity,
    Velocity,
    decode,
    header_at,
)
from agents.bases.senses import planar_yaw, wrapped
from agents.shell.ros_link import RosLink
from protocol.arrays import Reals
from protocol.bus.bus import Bus, Event, RawSample
from protocol.errors import BusError
from protocol.scenario.body import Base

PAUSE: Final = 1.5  # s at rest between two motions, in which poses are compared
EVERY: Final = 0.05  # s between two velocity commands
SILENCE: Final = 3.0  # s without commands, in which the base has to stop by itself


class Manoeuvre(NamedTuple):
    """A constant velocity command for a time."""

    duration: float  # s
    ahead: float  # m/s
    rate: float  # rad/s
    commanded: bool = True  # False: no command is sent


class PoseRow(NamedTuple):
    """A position from odometry or from a pose."""

    time: float  # s, of arrival
    x: float  # m
    y: float
    yaw: float  # rad, without jumps
    ahead: float = 0.0  # m/s, odometry only
    rate: float = 0.0  # rad/s, odometry only


class DriveLog(NamedTuple):
    """Manoeuvres and messages of a calibration."""

    moves: list[tuple[float, Manoeuvre]]  # with the time of its start, s
    odometry: list[PoseRow]
    poses: list[PoseRow]


def square(side: float, speed: float, rate: float) -> list[Manoeuvre]:
    """Four sides of `side` m, four corners, and half a side that no command ends."""
    rest = Manoeuvre(PAUSE, 0.0, 0.0)
    moves = [rest]
    for _ in range(4):
        moves += [Manoeuvre(side / speed, speed, 0.0), rest, Manoeuvre(0.5 * math.pi / rate, 0.0, rate), rest]
    return [*moves, Manoeuvre(0.5 * side / speed, speed, 0.0), Manoeuvre(SILENCE, 0.0, 0.0, commanded=False)]


class Calibration:
    """A `Node` that drives a base's manoeuvres over zenoh, once odometry and a pose have arrived.

    `wait` is the time for the first odometry and pose, s.

    Raises:
        BusError: odometry or poses do not arrive.
        MessageError: a message is invalid or of another type.
    """

    def __init__(self, bus: Bus, base: Base, moves: list[Manoeuvre], wait: float) -> None:
        self.topics = (  # topics of odometry and poses
            Topic(base.topic(base.odometry), ros.ODOMETRY),
            Topic(base.topic(base.pose), ros.STAMPED_POSE),
        )
        twist = ros.STAMPED_TWIST if base.stamped else ros.TWIST
        self._link = RosLink(bus, base)
        self._publish = self._link.publisher(Topic(base.topic(base.velocity), twist))
        self._given_up = time.monotonic() + wait
        self._link.subscribe(*self.topics)
        self.deadline, self.finished = 0.0, False
        self.log = DriveLog([], [], [])
        self._base, self._ahead = base, list(reversed(moves))
        self._until = math.inf

    def handle(self, event: Event) -> None:
        if isinstance(event, RawSample):
            self.on_message(self._link.topic_of(event), event.payload, time.monotonic())

    def on_message(self, topic: Topic, payload: bytes, now: float) -> None:
        """Process a message of one of `topics`."""
        if topic == self.topics[0]:
            message = decode(Odometry, payload)
            ahead, rate = message.velocity.linear[0], message.velocity.angular[2]
            self._append(self.log.odometry, now, message.pose, ahead, rate)
        else:
            self._append(self.log.poses, now, decode(StampedPose, payload).pose)

    def _append(self, rows: list[PoseRow], now: float, pose: Pose, *speeds: float) -> None:
        yaw = planar_yaw(pose)
        if yaw is not None:
            last = rows[-1].yaw if rows else 0.0
            x, y, _ = pose.position
            rows.append(PoseRow(now, x, y, last + wrapped(yaw - last), *speeds))

    def on_timer(self, now: float) -> None:
        """Publish the command that is due."""
        self.deadline = now + EVERY
        if missing := [topic.name for topic, rows in zip(self.topics, self.log[1:], strict=True) if not rows]:
            if now > self._given_up:
                raise BusError(
                    f"no message on {' and '.join(missing)}: check that their publishers, or a bridge with "
                    "that namespace, use the same router"
                )
            return
        if not self.log.moves or now >= self._until:
            if not self._ahead:
                self.finished = True
                self._command(0.0, 0.0)
                return
            move = self._ahead.pop()
            self.log.moves.append((now, move))
            self._until = now + move.duration
        move = self.log.moves[-1][1]
        self.deadline = min(self.deadline, self._until)
        if move.commanded:
            self._command(move.ahead, move.rate)

    def _command(self, ahead: float, rate: float) -> None:
        velocity = Velocity([ahead, 0.0, 0.0], [0.0, 0.0, rate])
        header = header_at(time.time_ns(), self._base.base_frame)
        self._publish((StampedVelocity(header, velocity) if self._base.stamped else velocity).serialize())


MARGIN: Final = 1.5  # stated bound over measured value
_BEGUN: Final = 0.1  # share of the speed above which the base has started
_FALLING: Final = 0.8  # share of the speed below which the base brakes


class MeasuredBounds(NamedTuple):
    """Measured properties of a base."""

    noise_bound: float  # m, largest distance of a pose at rest from their mean
    heading: float  # rad, likewise
    odometry: float  # relative error of odometry's distance, against poses
    error: float  # relative error of the driven distance, against the command
    lag: float  # s, from a velocity command to odometry that shows it
    timeout: float  # s, from the last command to odometry that shows braking
    acceleration: float  # m/s^2, deceleration after the timeout
    interval: float  # s, longest time between two odometry messages


def bounds(log: DriveLog) -> MeasuredBounds:
    """Measured properties, from the log of a square."""
    rests = [
        begin + move.duration
        for begin, move in log.moves
        if move.commanded and move.ahead == move.rate == 0.0
    ]  # their ends
    odometry, poses = np.array(log.odometry), np.array(log.poses)
    scatter = [here - here.mean(axis=0) for here in (_standing(poses, rest) for rest in rests)]
    noise = max(float(np.hypot(each[:, 0], each[:, 1]).max()) for each in scatter)
    heading = max(float(np.abs(each[:, 2]).max()) for each in scatter)
    timeout, acceleration = _stop(log)
    return MeasuredBounds(
        noise,
        heading,
        _slip(*([_place(rows, rest) for rest in rests] for rows in (odometry, poses))),
        _off(log, odometry),
        _lag(log),
        timeout,
        acceleration,
        max(b.time - a.time for a, b in pairwise(log.odometry)),
    )


def statements(found: MeasuredBounds) -> str:
    """Lines for a scenario: `MARGIN` times what was measured."""
    return "\n".join(
        (
            "[sensing]",
            "noise = 1e-3  # above 0; add a constant error of the poses to the bound",
            f"noise_bound = {_stated(MARGIN * found.noise_bound)}",
            f"heading = {_stated(MARGIN * found.heading)}",
            "",
            "[base]",
            f"timeout = {_stated(MARGIN * found.timeout)}",
            f"age = {_stated(MARGIN * found.interval)}",
            "",
            "[body]  # besides kind, radius, offset, track and speed, which are measured with a ruler",
            f"acceleration = {_stated(found.acceleration / MARGIN, math.floor)}",
            f"error = {_stated(MARGIN * found.error)}",
            f"lag = {_stated(MARGIN * found.lag)}",
            f"odometry = {_stated(MARGIN * found.odometry)}",
        )
    )


def _stated(value: float, rounded: Callable[[float], int] = math.ceil) -> str:
    if value <= 1e-6:
        return "0.0"
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{rounded(value / unit - 1e-9) * unit:.6g}"


def _standing(rows: Reals, end: float) -> Reals:
    """Positions and headings in the second half of a rest, when the base stands; else the nearest one."""
    chosen = rows[(rows[:, 0] >= end - 0.5 * PAUSE) & (rows[:, 0] <= end), 1:4]
    return chosen if len(chosen) else rows[[np.abs(rows[:, 0] - end).argmin()], 1:4]


def _place(rows: Reals, end: float) -> Reals:
    return np.asarray(_standing(rows, end)[:, :2].mean(axis=0))


def _slip(driven: Sequence[Reals], really: Sequence[Reals]) -> float:
    """Largest relative difference of a side's length between odometry and poses."""
    ways, true = (np.linalg.norm(np.diff(places, axis=0), axis=1) for places in (driven, really))
    sides = ways > 0.05
    return float((np.abs(true - ways)[sides] / ways[sides]).max(initial=0.0))


def _off(log: DriveLog, odometry: Reals) -> float:
    """Largest relative difference of a side's length between odometry and command."""
    worst = 0.0
    for (begin, move), (end, _) in pairwise(log.moves):
        if move.commanded and move.ahead > 0.0 and log.moves[-1][0] != end:
            way = math.dist(_place(odometry, begin), _place(odometry, end + PAUSE))
            worst = max(worst, abs(way - move.ahead * (end - begin)) / way)
    return worst


def _lag(log: DriveLog) -> float:
    """Longest time from the first command of a side to odometry that shows motion, s."""
    begun = []
    for begin, move in log.moves:
        if move.ahead > 0.0:
            later = (row.time for row in log.odometry if row.time > begin and row.ahead > _BEGUN * move.ahead)
            begun.append(next(later, math.inf) - begin)
    return max(begun)


def _stop(log: DriveLog) -> tuple[float, float]:
    """Time to the start of braking without commands, s, and deceleration, m/s^2."""
    silent, last = log.moves[-1][0], log.moves[-2][1]
    after = [row for row in log.odometry if row.time >= silent]
    low = [row for row in after if row.ahead < _FALLING * last.ahead]
    still = [row for row in after if row.ahead < (1.0 - _FALLING) * last.ahead]
    if not low or not still:
        return math.inf, 0.0
    fell = max(still[0].time - low[0].time, 1e-3)
    return low[0].time - silent, (2.0 * _FALLING - 1.0) * last.ahead / fell
