"""Messages as JSON objects: nothing is lost, and the schemas say what is there."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deploy.telemetry.recording.form import from_json, schema, to_object
from protocol.codec import encode
from protocol.keys import STREAMS
from tests.protocol.sample_messages import ANY

RECORDED = [stream for stream in STREAMS.values() if stream.recorded]
messages = st.one_of(*(ANY[stream.name] for stream in RECORDED))


@pytest.mark.slow
@given(messages)
def test_messages_survive_json_to_the_last_bit(message):
    text = msgspec.json.encode(to_object(message))
    assert encode(from_json(type(message), text)) == encode(message)


@given(messages)
def test_objects_keep_to_their_schema(message):
    content = msgspec.json.decode(msgspec.json.encode(to_object(message)))
    _conforms(content, schema(type(message)))


def _conforms(value, described: dict) -> None:
    kinds = {"boolean": bool, "integer": int, "number": float, "string": str, "object": dict, "array": list}
    assert type(value) is kinds[described["type"]]
    if described["type"] == "array":
        for item in value:
            _conforms(item, described["items"])
    elif described["type"] == "object":
        assert set(described.get("required", ())) <= set(value)
        for name, inner in value.items():
            _conforms(inner, described["properties"].get(name) or described["additionalProperties"])


@pytest.mark.parametrize("stream", RECORDED, ids=lambda stream: stream.name)
def test_schemas_keep_to_what_foxglove_reads(stream):
    """Its parser wants properties in every object, one plain type each, and no arrays of arrays."""

    def check(described: dict) -> None:
        assert described["type"] in ("boolean", "integer", "number", "string", "object", "array")
        if described["type"] == "object":
            for inner in described["properties"].values():
                check(inner)
        if described["type"] == "array":
            assert described["items"]["type"] != "array"
            check(described["items"])

    check(schema(stream.message))
