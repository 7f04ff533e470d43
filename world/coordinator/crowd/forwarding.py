"""Letters: messages between robots that do not receive each other's States. A Command brings one, and the
next Tick of each addressee has its part.

In lock-step nobody has to await a letter, and no rule of a router is needed for it: who may command as a
robot may write as it.
"""

from __future__ import annotations

from collections import defaultdict

from msgspec.structs import replace

from protocol.messages import Command, Letter


class Forwarding:
    """Letters of the tick that ends, for that which begins."""

    def __init__(self) -> None:
        self._under_way: defaultdict[int, list[Letter]] = defaultdict(list)

    def send(self, command: Command) -> None:
        """Take the letter of a command that was accepted; one in another's name is none."""
        letter = command.letter
        if letter is None or (letter.robot, letter.incarnation) != (command.robot, command.incarnation):
            return
        addressed = [each.peer for each in letter.proposals] + [each.peer for each in letter.answers]
        for peer in dict.fromkeys(addressed):
            part = replace(
                letter,
                proposals=tuple([each for each in letter.proposals if each.peer == peer]),
                answers=tuple([each for each in letter.answers if each.peer == peer]),
            )
            self._under_way[peer].append(part)

    def deliver(self) -> dict[int, tuple[Letter, ...]]:
        """All letters by addressee, each handed out once; those of one tick by sender."""
        delivered = {
            peer: tuple(sorted(letters, key=lambda letter: letter.robot))
            for peer, letters in self._under_way.items()
        }
        self._under_way.clear()
        return delivered
