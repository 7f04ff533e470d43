"""Draw the poses of a ROS 2 file that `disknav recording replay --ros2` wrote: python poses.py poses.mcap."""

import sys
from collections import defaultdict
from pathlib import Path

import matplotlib.pyplot as plt
from rosbags.highlevel import AnyReader

if not sys.argv[1:]:
    sys.exit(__doc__)
paths = defaultdict(list)
with AnyReader([Path(sys.argv[1])]) as bag:
    for connection, _, data in bag.messages():
        for each in bag.deserialize(data, connection.msgtype).transforms:
            paths[each.child_frame_id].append((each.transform.translation.x, each.transform.translation.y))

figure, axes = plt.subplots(figsize=(4, 4), subplot_kw={"aspect": "equal"}, layout="constrained")
for name, path in sorted(paths.items()):
    axes.plot(*zip(*path, strict=True), label=name)
axes.set(xlabel="x, m", ylabel="y, m", title="/tf, as rosbags reads it")
axes.legend(fontsize=7)
figure.savefig("poses.png", dpi=90)
