"""A bad cable: two Ethernet devices, and between them delay and loss.

Frames, not streams, are delayed and lost, so that what TCP makes of it (retransmission, stalls,
smaller windows) is what the kernel's own TCP makes of a bad link, under TLS as without.
"""

from __future__ import annotations

import fcntl
import os
import select
import struct
import sys
import time
from collections import deque
from random import Random

_SET_INTERFACE = 0x400454CA  # TUNSETIFF of <linux/if_tun.h>
_TAP, _BARE = 0x0002, 0x1000  # IFF_TAP, IFF_NO_PI
_FRAME = 1 << 16  # bytes


def device() -> tuple[int, str]:
    """A new Ethernet device whose cable ends in this process: descriptor and name."""
    descriptor = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    answer = fcntl.ioctl(descriptor, _SET_INTERFACE, struct.pack("16sH22x", b"bad%d", _TAP | _BARE))
    return descriptor, struct.unpack("16s", answer[:16])[0].rstrip(b"\0").decode()


def relay(ends: tuple[int, int], delay: float, loss: float, random: Random) -> None:
    """Carry frames both ways: each is lost with probability `loss`, else `delay` s late, in order."""
    other = {ends[0]: ends[1], ends[1]: ends[0]}
    under_way: deque[tuple[float, int, bytes]] = deque()  # due (s, monotonic), to where, frame
    while True:
        wait = max(0.0, under_way[0][0] - time.monotonic()) if under_way else None
        for end in select.select(ends, [], [], wait)[0]:
            frame = os.read(end, _FRAME)
            if random.random() >= loss:
                under_way.append((time.monotonic() + delay, other[end], frame))
        while under_way and under_way[0][0] <= time.monotonic():
            _, end, frame = under_way.popleft()
            os.write(end, frame)


def main(delay: str, loss: str) -> None:
    """Say the names of the two devices, and relay between them for ever."""
    (one, first), (two, second) = device(), device()
    print(first, second, flush=True)
    sys.stdin.readline()  # until they are where they belong and up
    relay((one, two), float(delay), float(loss), Random(1))


if __name__ == "__main__":
    main(*sys.argv[1:])
