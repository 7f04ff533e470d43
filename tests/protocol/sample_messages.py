"""Messages of every stream: `ANY` that may be sent, for hypothesis, and `ONE` of each as an example."""

from typing import Any

from hypothesis import strategies as st
from msgspec import inspect

from protocol.keys import STREAMS
from protocol.messages import (
    HIGHEST_ID,
    Answer,
    Clock,
    Command,
    FirstLine,
    GoalStatus,
    Grants,
    Health,
    ListedBinding,
    Member,
    Message,
    PlacedObstacle,
    Proposal,
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

_POINT = ((0.5, -0.25),)  # of what is checked beyond its types: a disk's centre
_BINDINGS = (ListedBinding(7, -1, (0.6, 0.8, 0.4)), ListedBinding(6, -2, None, _POINT, 0.05, True))
_CHECKED: dict[type, dict[str, st.SearchStrategy[Any]]] = {
    Member: {"position": st.just(_POINT[0])},
    FirstLine: {"nx": st.just(0.6), "ny": st.just(-0.8)},
    Grants: {
        "life": st.integers(0, 5),
        "version": st.integers(7, 2**53),
        "number": st.integers(0, 7),
        "bindings": st.sampled_from([(), _BINDINGS]),
    },
    PlacedObstacle: {"points": st.just(_POINT)},
}


_PLAIN: dict[type[inspect.Type], st.SearchStrategy[Any]] = {
    inspect.StrType: st.text(max_size=9),
    inspect.BytesType: st.binary(max_size=32),
    inspect.BoolType: st.booleans(),
    inspect.NoneType: st.none(),
}


def _of(kind: Any) -> st.SearchStrategy[Any]:
    """Any value of a type of messages, within the bounds that its annotation states."""
    match kind:
        case inspect.Metadata():
            return _of(kind.type)
        case inspect.StructType():
            fields = {each.name: _of(each.type) for each in kind.fields}
            return st.builds(kind.cls, **(fields | _CHECKED.get(kind.cls, {})))
        case inspect.UnionType():
            return st.one_of(*map(_of, kind.types))
        case inspect.TupleType():
            return st.tuples(*map(_of, kind.item_types))
        case inspect.VarTupleType():
            return st.lists(_of(kind.item_type), max_size=3).map(tuple)
        case inspect.DictType():
            return st.dictionaries(_of(kind.key_type), _of(kind.value_type), max_size=2)
        case inspect.LiteralType():
            return st.sampled_from(kind.values)
        case inspect.IntType():
            return st.integers(kind.ge, kind.le)
        case inspect.FloatType():
            return st.floats(kind.ge, kind.le)
    return _PLAIN[type(kind)]


ANY = {name: _of(inspect.type_info(stream.message)) for name, stream in STREAMS.items()}
ids = st.integers(1, HIGHEST_ID)

_DOWN = (Standing(2, 1, (0.3, 0.4)),)
_ROSTER = Roster(4, (Member(1, 2, "live", 0.04), Member(2, 1, "standing", 0.04, (0.3, 0.4), 0.0)))
_LISTED = (ListedBinding(7, 3, (1.0, 0.0, 0.4)), ListedBinding(6, -2, None, ((0.1, 0.2),), 0.05, True))
_GRANTS = Grants(5, 9, 8, (0.5, 0.25, 0.1), _LISTED)
_LINES = {"proposals": (Proposal(3, 1, 7, 1.0, 0.0, 0.1),), "answers": (Answer(3, 1, 4, 5),)}
ONE: dict[str, Message] = {
    "tick": Tick(1, 2, 3, (1, 3), sense=Sense(None, 3, 0.01, (0.1, 0.2)), roster=_ROSTER, grants=_GRANTS),
    "state": State(1, 2, 3, (0.5, 0.25), 0.1, 0.2, 0.3, (0.1, 0.2), **_LINES),  # type: ignore[arg-type]  # each is
    "command": Command(1, 2, 3, (0.1, 0.2), roster=4),
    "clock": Clock(3, 0.15, (1, 3), _DOWN, "", 0.01, 0.5, "why", True),
    "summary": Summary(3, bytes((1, 0, 0, 0, 1, 0, 0, 0)), bytes(8), bytes(4), bytes(4)),
    "truth": Truth(3, (1, 2), ((0.1, 0.2), (0.3, 0.4)), 0.01, 0.5),
    "health": Health(1, 2, 3, 0.1, 10, 20, {"shape": 1}, ((3, 2),), ((3, 1.0, 0.0, 0.1),), "ok"),
    "goalstatus": GoalStatus(1, 3, 2, "under way", (0.5, 0.25), 4),
    "wish": Wish(1, (0.1, 0.2)),
    "result": Result("{}"),
}
