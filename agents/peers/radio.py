"""The radio of one robot in a wireless network: its bad times, its gaps, and its turn on the shared medium.

All of it follows from (seed, robot, tick), so that sender and receivers agree, and a later life of a robot
finds what an earlier one found.
"""

from __future__ import annotations

from typing import Final

from protocol.draws import Purpose, generator
from protocol.scenario.body import span_of
from protocol.scenario.model import Scenario
from protocol.scenario.network import Burst, Roaming

_BLOCK: Final = 64  # ticks drawn at once: making a generator costs as much as some hundred numbers
_BLOCKS: Final = 4  # that are remembered: States are late


class Radio:
    """What one robot's radio does at each tick.

    Args:
        scenario: the run.
        robot: id.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self._scenario, self._robot = scenario, robot
        self._blocks: dict[int, list[list[float]]] = {}
        step, burst, roaming = scenario.time.step, scenario.link.burst or Burst(), scenario.link.roaming
        self._worse, self._better = min(0.5, step / burst.good), min(0.5, step / burst.bad)
        self._roaming = roaming or Roaming()
        self._window = max(1, scenario.ticks(self._roaming.every))
        self._is_bad, self._tick = False, -1

    def is_bad(self, tick: int) -> bool:
        """Whether its channel is bad, by the chain of Gilbert and Elliott.

        A draw below `worse` makes it bad and one above 1 - `better` good, whatever it was: the last such draw
        decides, and nothing has to be remembered.
        """
        for earlier in range(tick, -1, -1):
            if earlier == self._tick:
                break
            draw = self._draws(earlier)[0]
            if draw < self._worse or draw >= 1.0 - self._better:
                self._is_bad = draw < self._worse
                break
        else:
            self._is_bad = False
        self._tick = tick
        return self._is_bad

    def back(self, tick: int) -> int:
        """The first tick at or after `tick` at which it has an access point."""
        if self._scenario.link.roaming is None:
            return tick
        window = tick // self._window
        for each in (window - 1, window):  # a gap ends before the next window does
            begin, end = self._gap(each) if each >= 0 else (0, 0)
            if begin <= tick < end:
                return self.back(end)
        return tick

    def turn(self, tick: int) -> float:
        """A robot with a smaller one sends earlier in a tick."""
        return self._draws(tick)[1]

    def _gap(self, window: int) -> tuple[int, int]:
        """First tick of a window's gap, and the first one after it."""
        low, high = span_of(self._roaming.gap)
        _, _, place, length = self._draws(window * self._window)
        begin = window * self._window + int(place * self._window)
        return begin, begin + self._scenario.ticks(low + length * (high - low))

    def _draws(self, tick: int) -> list[float]:
        number, row = divmod(tick, _BLOCK)
        block = self._blocks.get(number)
        if block is None:
            source = generator(self._scenario.seed, Purpose.RADIO, self._robot, number)
            block = self._blocks[number] = source.random((_BLOCK, 4)).tolist()
            if len(self._blocks) > _BLOCKS:
                del self._blocks[next(iter(self._blocks))]
        return block[row]
