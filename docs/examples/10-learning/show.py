"""Play the trained policy with fresh and late messages: python show.py [EPISODES]; writes shown.png."""

import sys
from collections import deque

import matplotlib.pyplot as plt
import numpy as np
from train import episodes, policy

weights, count = np.load("policy.npy"), int(sys.argv[1]) if sys.argv[1:] else 20
figure, axes = plt.subplots(1, 2, figsize=(7, 3.5), layout="constrained")
print("delay  filter  contact  all arrived  closest, mm")
for delay in (0.0, 0.3):
    for filtered in (False, True):
        env, verdicts, closest = episodes(filtered, delay), [], np.inf
        for seed in range(100, 100 + count):
            seen, _ = env.reset(seed=seed)
            late = deque([seen], maxlen=1 + env.simulation.scenario.ticks(delay))  # what the policy sees
            while env.agents:
                seen, *_, infos = env.step({agent: policy(weights, each) for agent, each in late[0].items()})
                late.append(seen)
                closest = min(closest, infos["robot_1"]["clearance"])
            verdicts.append(infos["robot_1"]["verdict"])
        touched, arrived = verdicts.count("collision"), verdicts.count("arrived")
        name = "with" if filtered else "without"
        print(f"{delay:5} {name:>7} {touched:8} {arrived:12} {round(1e3 * closest, 1) + 0.0:12}")
        if delay:
            trajectory, side = env.simulation.trajectory, axes[int(filtered)]
            side.plot(*np.moveaxis(trajectory.positions, 2, 0))
            for spec, place in zip(env.simulation.scenario.robots, trajectory.positions[-1], strict=True):
                side.add_patch(plt.Circle(place, spec.radius, fill=False))
            side.set(title=f"{name} the filter, {delay} s late", aspect="equal")
figure.savefig("shown.png", dpi=90)
