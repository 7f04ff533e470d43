"""Two mappings of ROS 2 topics to zenoh: keys, attachments, and announcements.

ros2dds: as zenoh-bridge-ros2dds maps them. A key is `<namespace>/<topic>`; a payload is CDR, alone.
rmw_zenoh: as rmw_zenoh_cpp's nodes do. A key is `<domain>/<topic>/<type>/<hash>`; an attachment has a
sequence number, a time and the publisher's gid; liveliness tokens under `@ros2_lv` announce nodes, publishers
and subscriptions to tools such as `ros2 topic list`.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Callable
from hashlib import blake2b
from typing import Final, Literal, NamedTuple

from protocol.errors import MessageError
from protocol.scenario.body import Base

# Types, and the RIHS01 hashes of their definitions, which are the same from Iron on.
TWIST, STAMPED_TWIST = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
STAMPED_POSE, ODOMETRY = "geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Odometry"
BOOL, TF = "std_msgs/msg/Bool", "tf2_msgs/msg/TFMessage"
MARKERS = "visualization_msgs/msg/MarkerArray"
HASHES: Final = {
    TWIST: "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    STAMPED_TWIST: "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
    STAMPED_POSE: "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8",
    ODOMETRY: "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    BOOL: "feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9",
    TF: "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    MARKERS: "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
}

NODE: Final = "disknav"  # name of a robot's process in the graph of ROS 2
_ATTACHMENT: Final = struct.Struct("<qqB16s")  # sequence number, ns since 1970, length of the gid, gid
_GID: Final = 16  # bytes
# reliable, volatile, the last ten; no deadline, lifespan or lease: every number as `rmw/types.h` has it
_QUALITY: Final = "1:2:1,10:,:,:,,"

Attach = Callable[[], bytes]
EntityKind = Literal["NN", "MP", "MS"]  # node, publisher, subscription


class Topic(NamedTuple):
    """A topic: its full name without the first slash, and the type of its messages."""

    name: str
    type: str


class Dialect:
    """The mapping of topics to zenoh by zenoh-bridge-ros2dds, which names no types."""

    def key(self, topic: Topic) -> str:
        """The key under which a topic's messages are published."""
        return topic.name

    def expression(self, topic: Topic) -> str:
        """The key expression to subscribe to."""
        return topic.name

    def name(self, key: str) -> str:
        """The name of the topic of a key."""
        return key

    def check(self, topic: Topic, key: str, attachment: bytes) -> None:
        """Raise MessageError if a sample under a topic's expression is none of its messages."""

    def attach(self, token: str) -> Attach | None:  # noqa: ARG002
        """The attachments of messages of the publisher with `token`; None if there are none."""
        return None

    def token(self, session: str, number: int, kind: EntityKind, topic: Topic | None) -> str:  # noqa: ARG002
        """The liveliness token of a session's node, or its numbered publisher or subscription; "" if none."""
        return ""


class RmwZenoh(Dialect):
    """The dialect of rmw_zenoh_cpp; `domain` is ROS_DOMAIN_ID, `namespace` that of the robot's node."""

    def __init__(self, domain: int, namespace: str) -> None:
        self._domain, self._namespace = domain, _mangled(namespace.strip("/"))

    def key(self, topic: Topic) -> str:
        return f"{self._domain}/{topic.name}/{_typed(topic)}"

    def expression(self, topic: Topic) -> str:
        return f"{self._domain}/{topic.name}/*/*"  # so that another type or hash is reported

    def name(self, key: str) -> str:
        return "/".join(key.split("/")[1:-2])

    def check(self, topic: Topic, key: str, attachment: bytes) -> None:
        if key != self.key(topic):
            theirs = "/".join(key.split("/")[-2:])
            raise MessageError("type", f"{topic.name} comes as {theirs}, not as {_typed(topic)}")
        if len(attachment) != _ATTACHMENT.size or attachment[16] != _GID:
            text = f"{len(attachment)} bytes, not of {_ATTACHMENT.size} with a gid of {_GID}"
            raise MessageError("shape", f"{topic.name} comes with an attachment of {text}")

    def attach(self, token: str) -> Attach:
        gid = blake2b(token.encode(), digest_size=_GID).digest()
        number = 0

        def attachment() -> bytes:
            nonlocal number
            number += 1
            return _ATTACHMENT.pack(number, time.time_ns(), _GID, gid)

        return attachment

    def token(self, session: str, number: int, kind: EntityKind, topic: Topic | None) -> str:
        node = f"@ros2_lv/{self._domain}/{session}/0/{number}/{kind}/%/{self._namespace}/{NODE}"
        return node if topic is None else f"{node}/{_mangled(topic.name)}/{_typed(topic)}/{_QUALITY}"


def _mangled(name: str) -> str:
    return "%" + name.replace("/", "%")


def _typed(topic: Topic) -> str:
    package, _, name = topic.type.split("/")
    return f"{package}::msg::dds_::{name}_/RIHS01_{HASHES[topic.type]}"


def dialect_of(base: Base) -> Dialect:
    """The dialect of a base's topics."""
    return RmwZenoh(base.domain, base.namespace) if base.dialect == "rmw_zenoh" else Dialect()
