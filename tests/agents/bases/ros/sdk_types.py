"""Messages of ROS 2 Jazzy for zenoh-ros2-sdk, for the programs in this folder."""

from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
T = STORE.types


def described(kind):
    return {
        "msg_type": kind,
        "msg_definition": STORE.generate_msgdef(kind)[0],
        "type_hash": STORE.hash_rihs01(kind),
    }
