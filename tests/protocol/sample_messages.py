"""Messages of every stream: `ANY` that may be sent, for hypothesis, and `ONE` of each as an example."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from protocol.messages import (
    LARGEST,
    Answer,
    BaseMotion,
    Claim,
    Clock,
    Command,
    FirstLine,
    GoalStatus,
    Grants,
    Handling,
    Health,
    ListedBinding,
    Member,
    Message,
    Proposal,
    Report,
    Result,
    Roster,
    Sense,
    Standing,
    State,
    Summary,
    Tick,
    Truth,
    Wish,
)

numbers = st.floats(-LARGEST, LARGEST)
sizes = st.floats(0, LARGEST)
cosines = st.floats(-1.0, 1.0)
ids = st.integers(1, 999_999_999)
counts = st.integers(0, 2**53)
epochs = st.integers(0, 2**32 - 1)
vectors = st.tuples(numbers, numbers)
positions = st.none() | vectors


def several(one: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.lists(one, max_size=3).map(tuple)


downs = several(st.builds(Standing, ids, counts, vectors))
members = several(
    st.builds(Member, ids, counts, st.sampled_from(["live", "gone"]), sizes, positions, sizes)
    | st.builds(Member, ids, counts, st.sampled_from(["appearing", "standing"]), sizes, vectors, sizes)
)
rosters = st.none() | st.builds(Roster, counts, members)
proposals = several(st.builds(Proposal, ids, counts, counts, cosines, cosines, numbers))
answers = several(st.builds(Answer, ids, counts, counts, counts))
motions = st.none() | st.builds(BaseMotion, vectors, numbers, vectors)
senses = st.none() | st.builds(Sense, positions, counts, sizes, vectors, sizes, motions)
claims = st.none() | st.builds(Claim, ids, sizes, sizes)
states = st.builds(
    State, ids, counts, counts, positions, sizes, sizes, sizes, vectors, epochs, proposals, answers, claims
)
disks = st.integers(-999_999_999, 999_999_999)
lines = st.tuples(cosines, cosines, numbers)
bindings = several(
    st.builds(ListedBinding, counts, disks, st.none() | lines)
    | st.builds(ListedBinding, counts, disks, st.none() | lines, st.tuples(vectors), sizes, st.booleans())
)
grants = st.none() | st.builds(
    Grants, counts, counts, counts, st.none() | st.tuples(numbers, numbers, sizes), bindings
)
firsts = several(st.builds(FirstLine, counts, cosines, cosines, numbers))
handlings = st.none() | st.builds(Handling, ids, sizes, positions)
ANY: dict[str, st.SearchStrategy[Any]] = {
    "tick": st.builds(
        Tick,
        ids,
        counts,
        counts,
        several(ids),
        epochs,
        senses,
        rosters,
        positions,
        st.booleans(),
        st.booleans(),
        heard=st.none() | counts,
        grants=grants,
    ),
    "state": states,
    "command": st.builds(
        Command,
        ids,
        counts,
        counts,
        vectors,
        epochs,
        counts,
        several(ids),
        report=st.none() | st.builds(Report, vectors, sizes),
        version=counts,
        region=counts,
        firsts=firsts,
        handles=handlings,
        slice=st.none() | sizes,
    ),
    "clock": st.builds(
        Clock,
        counts,
        sizes,
        several(ids),
        downs,
        st.text(max_size=9),
        numbers,
        numbers,
        st.text(max_size=9),
        st.booleans(),
    ),
    "summary": st.builds(
        Summary, counts, st.binary(max_size=8), st.binary(max_size=32), st.binary(max_size=16)
    ),
    "truth": st.builds(Truth, counts, several(ids), several(vectors), numbers, numbers),
    "health": st.builds(
        Health,
        ids,
        counts,
        counts,
        sizes,
        counts,
        counts,
        st.dictionaries(st.text(max_size=9), counts, max_size=2),
        several(st.tuples(ids, counts)),
        several(st.tuples(ids, cosines, cosines, numbers)),
        st.text(max_size=9),
    ),
    "goalstatus": st.builds(
        GoalStatus,
        ids,
        counts,
        counts,
        st.sampled_from(["under way", "arrived", "cancelled", "given up"]),
        vectors,
        counts,
    ),
    "wish": st.builds(Wish, ids, vectors),
    "result": st.builds(Result, st.text(max_size=50)),
}

_DOWN = (Standing(2, 1, (0.3, 0.4)),)
_ROSTER = Roster(4, (Member(1, 2, "live", 0.04), Member(2, 1, "standing", 0.04, (0.3, 0.4), 0.0)))
_GRANTS = Grants(
    5,
    9,
    8,
    (0.5, 0.25, 0.1),
    (ListedBinding(7, 3, (1.0, 0.0, 0.4)), ListedBinding(6, -2, None, ((0.1, 0.2),), 0.05, True)),
)
ONE: dict[str, Message] = {
    "tick": Tick(1, 2, 3, (1, 3), sense=Sense(None, 3, 0.01, (0.1, 0.2)), roster=_ROSTER, grants=_GRANTS),
    "state": State(
        1,
        2,
        3,
        (0.5, 0.25),
        0.1,
        0.2,
        0.3,
        (0.1, 0.2),
        proposals=(Proposal(3, 1, 7, 1.0, 0.0, 0.1),),
        answers=(Answer(3, 1, 4, 5),),
    ),
    "command": Command(1, 2, 3, (0.1, 0.2), roster=4),
    "clock": Clock(3, 0.15, (1, 3), _DOWN, "", 0.01, 0.5, "why", True),
    "summary": Summary(3, bytes((1, 0, 0, 0, 1, 0, 0, 0)), bytes(8), bytes(4), bytes(4)),
    "truth": Truth(3, (1, 2), ((0.1, 0.2), (0.3, 0.4)), 0.01, 0.5),
    "health": Health(1, 2, 3, 0.1, 10, 20, {"shape": 1}, ((3, 2),), ((3, 1.0, 0.0, 0.1),), "ok"),
    "goalstatus": GoalStatus(1, 3, 2, "under way", (0.5, 0.25), 4),
    "wish": Wish(1, (0.1, 0.2)),
    "result": Result("{}"),
}
