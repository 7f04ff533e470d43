"""Letters reach whom they are addressed to, once, whatever order they came in."""

from protocol.messages import Answer, Command, Letter, Proposal
from world.coordinator.crowd.forwarding import Forwarding


def proposal(peer: int) -> Proposal:
    return Proposal(peer, 1, 1, 1.0, 0.0, 0.0)


def command(
    robot: int, proposals: tuple[int, ...], answers: tuple[int, ...] = (), writer: int = 0
) -> Command:
    letter = Letter(
        writer or robot,
        1,
        5,
        tuple(proposal(peer) for peer in proposals),
        tuple(Answer(peer, 1, 0, 0) for peer in answers),
    )
    return Command(robot, 1, 5, (0.0, 0.0), letter=letter)


def test_each_gets_its_own_part_by_sender() -> None:
    post = Forwarding()
    post.send(command(3, (4, 9), answers=(1,)))
    post.send(command(2, (4,)))
    post.send(Command(5, 1, 5, (0.0, 0.0)))
    delivered = post.deliver()
    assert delivered.keys() == {1, 4, 9}
    assert [letter.robot for letter in delivered[4]] == [2, 3]
    assert all(letter.proposals == (proposal(4),) and not letter.answers for letter in delivered[4])
    assert [(letter.proposals, len(letter.answers)) for letter in delivered[1]] == [((), 1)]
    assert post.deliver() == {}


def test_nobody_writes_in_anothers_name() -> None:
    post = Forwarding()
    post.send(command(3, (4,), writer=2))
    assert post.deliver() == {}
