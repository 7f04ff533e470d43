"""Train a linear policy by the cross-entropy method: python train.py [GENERATIONS]; writes policy.npy."""

import sys

import numpy as np

import disknav


def episodes(filtered, delay=0.0):
    """An environment of six robots with random starts; they have arrived within 3 cm."""
    settings = {"time.limit": 8, "time.tolerance": 0.03, "link.delay": delay}
    return disknav.parallel_env(lambda seed: disknav.load("random-6", settings, seed=seed), filtered)


def policy(weights, seen):
    """Velocity from one observation: along the goal and across it, and the same of each near neighbour."""
    way, peers = seen[2] + 1j * seen[3], seen[4:].reshape(-1, 5)
    goal, ways = way / max(abs(way), 0.02), peers[:, 0] + 1j * peers[:, 1]
    near = (ways / np.abs(ways) * np.maximum(0.0, 1.0 - peers[:, 4] / 0.06)).sum()
    velocity = 0.1 * complex(np.dot(weights, [goal, 1j * goal, near, 1j * near]))
    return velocity.real, velocity.imag


if __name__ == "__main__":
    env, random = episodes(filtered=False), np.random.default_rng(1)
    mean, spread = np.zeros(4), np.ones(4)
    for generation in range(int(sys.argv[1]) if sys.argv[1:] else 12):
        tried, returns = mean + spread * random.normal(size=(20, 4)), np.zeros(20)
        for each, weights in enumerate(tried):  # distance to the goals costs, and overlap costs more
            seen, _ = env.reset(seed=generation)
            while env.agents:
                seen, *_, infos = env.step({agent: policy(weights, own) for agent, own in seen.items()})
                returns[each] -= np.mean([np.hypot(*own[2:4]) for own in seen.values()])
                returns[each] -= 10.0 * (infos["robot_1"]["clearance"] < -1e-9)
        best = tried[np.argsort(returns)[-5:]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.02
        print(f"{generation}: return {returns.mean():.1f}, best {returns.max():.1f}, weights {mean.round(2)}")
    np.save("policy.npy", mean)
