"""Messages of every stream, for hypothesis: any that may be sent."""

from typing import Any

from hypothesis import strategies as st
from msgspec import inspect

from protocol.keys import STREAMS
from protocol.messages import HIGHEST_ID, FirstLine, Grants, ListedBinding, Member, PlacedObstacle

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
