"""How ROS 2 topics cross zenoh, against implementations that others wrote: pamoja-ros2 and rosbags."""

import struct
import time

import pytest
from pamoja import ros2 as pamoja
from rosbags.typesys import Stores, get_typestore

from agents.bases import dialects as ros
from agents.bases.dialects import HASHES, RmwZenoh, Topic, dialect_of
from agents.bases.ros_messages import Velocity
from protocol.errors import MessageError
from protocol.scenario.body import Base

DIALECT = RmwZenoh(7, "/bot1")
TWIST = Topic("bot1/cmd_vel", ros.TWIST)
SESSION = "8d1f4f3e2b0a"


STORES = [get_typestore(store) for store in (Stores.ROS2_IRON, Stores.ROS2_JAZZY, Stores.ROS2_KILTED)]


@pytest.mark.parametrize("kind", HASHES)
def test_hashes_and_keys_are_those_that_others_make(kind):
    name = f"RIHS01_{HASHES[kind]}"
    assert {store.hash_rihs01(kind) for store in STORES} == {name}
    assert bytes(pamoja.type_hash_digest(name)).hex() == HASHES[kind]
    assert DIALECT.key(Topic("bot1/a", kind)) == pamoja.entity_key(7, "/bot1/a", kind, name)


def test_a_twist_is_what_pamoja_reads_and_writes():
    linear, angular = (0.1, -2.0, 3.0), (1e-9, 0.0, -7.5)
    payload = Velocity([*linear], [*angular]).serialize()
    assert pamoja.twist_from_cdr(payload) == (linear, angular)
    assert bytes(pamoja.twist_to_cdr(linear, angular)) == payload


def test_tokens_name_node_publisher_and_subscription_as_the_graph_cache_reads_them():
    node = DIALECT.token(SESSION, 0, "NN", None)
    assert node == f"@ros2_lv/7/{SESSION}/0/0/NN/%/%bot1/disknav"
    publisher = DIALECT.token(SESSION, 3, "MP", TWIST).split("/")
    assert publisher[:9] == ["@ros2_lv", "7", SESSION, "0", "3", "MP", "%", "%bot1", "disknav"]
    assert publisher[9] == pamoja.percent_mangle("/bot1/cmd_vel")
    assert "/".join(publisher[10:12]) == DIALECT.key(TWIST).partition("cmd_vel/")[2]
    assert publisher[12] == "1:2:1,10:,:,:,,"  # reliable, volatile, keep the last 10
    root = RmwZenoh(0, "/").token(SESSION, 0, "NN", None)
    assert root.endswith("/NN/%/%/disknav")


def test_an_attachment_has_33_bytes_a_number_that_grows_the_time_and_a_gid_per_publisher():
    attach = DIALECT.attach(DIALECT.token(SESSION, 1, "MP", TWIST))
    other = DIALECT.attach(DIALECT.token(SESSION, 2, "MP", TWIST))
    before = time.time_ns()
    (one, first, length, gid), (two, _, _, same) = (struct.unpack("<qqB16s", attach()) for _ in range(2))
    assert (one, two, length) == (1, 2, 16)
    assert before <= first <= time.time_ns()
    assert gid == same != struct.unpack("<qqB16s", other())[3]


GOOD = DIALECT.attach("x")()
HASH, TYPE = DIALECT.key(TWIST)[:-1] + "b", DIALECT.key(Topic("bot1/cmd_vel", ros.STAMPED_TWIST))


@pytest.mark.parametrize(
    ("key", "attachment", "reason", "says"),
    [
        (HASH, GOOD, "type", "bot1/cmd_vel comes as geometry_msgs::msg::dds_::Twist_/RIHS01_9c"),
        (TYPE, GOOD, "type", "as geometry_msgs::msg::dds_::TwistStamped_"),
        (DIALECT.key(TWIST), b"", "shape", "an attachment of 0 bytes"),
        (DIALECT.key(TWIST), GOOD[:-1], "shape", "an attachment of 32 bytes"),
        (DIALECT.key(TWIST), GOOD[:16] + b"\x11" + GOOD[17:], "shape", "a gid of 16"),
    ],
    ids=["hash", "type", "none", "short", "gid"],
)
def test_another_type_or_hash_and_a_bad_attachment_are_refused(key, attachment, reason, says):
    DIALECT.check(TWIST, DIALECT.key(TWIST), GOOD)
    assert DIALECT.name(key) == TWIST.name
    with pytest.raises(MessageError, match=says) as refused:
        DIALECT.check(TWIST, key, attachment)
    assert refused.value.reason == reason


def test_the_bridge_has_plain_keys_and_puts_every_name_into_its_namespace():
    base = Base(namespace="/bot1")
    dialect = dialect_of(base)
    topic = Topic(base.topic("/tf"), ros.TF)
    assert dialect.key(topic) == dialect.expression(topic) == dialect.name("bot1/tf") == "bot1/tf"
    assert dialect.attach("") is None
    assert dialect.token(SESSION, 0, "NN", None) == ""
    assert Base(namespace="/bot1", dialect="rmw_zenoh").topic("/tf") == "tf"
