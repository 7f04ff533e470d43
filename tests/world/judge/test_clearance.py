import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tests.world.driving import scenario
from world.judge.clearance import Disks, gaps
from world.judge.surroundings import Surroundings

SAMPLES = 2001
coordinate = st.floats(-0.3, 0.3)
point = st.builds(complex, coordinate, coordinate)


@given(st.lists(st.tuples(point, point, st.floats(0.001, 0.1)), min_size=1, max_size=5))
def test_gaps_agree_with_dense_sampling(motions):
    """No sampled instant is closer, and some sampled instant is as close as sampling can tell."""
    before = np.array([start for start, _, _ in motions])
    after = np.array([end for _, end, _ in motions])
    radii = [radius for _, _, radius in motions]
    setting = scenario(*[((0.0, 0.0), (0.0, 0.0))] * len(motions))
    disks = Disks(setting)
    disks.contact = np.array([radii[i] + radii[j] for i, j in zip(disks.first, disks.second, strict=True)])
    disks.surroundings = Surroundings(setting.workspace.shape, {}, np.array(radii))
    found = gaps(disks, before, after)

    share = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    path = before + share * (after - before)
    apart = np.abs(path[:, disks.first] - path[:, disks.second]) - disks.contact
    inside = disks.surroundings.wall - np.abs(path)
    sampled = np.concatenate((apart, inside), axis=1).min(axis=0)
    travelled = np.concatenate((np.abs(disks.relative(after - before)), np.abs(after - before)))
    assert np.all(found <= sampled + 1e-12)
    assert np.all(found >= sampled - travelled / (SAMPLES - 1) - 1e-12)


def test_closest_approach_lies_inside_the_tick():
    disks = Disks(scenario(((0.0, 0.0), (0.0, 0.0)), ((0.0, 0.0), (0.0, 0.0)), radius=0.01))
    found = gaps(disks, np.array([-0.1 + 0.05j, 0.1 + 0j]), np.array([0.1 + 0.05j, -0.1 + 0j]))
    assert found[0] == np.float64(0.05 - 0.02)
    assert found[1] == 0.29 - abs(0.1 + 0.05j)


def test_pairs_are_named_by_id_whatever_their_order_in_the_scenario():
    setting = scenario(*[((0.1 * n, 0.0), (0.0, 0.0)) for n in range(3)])
    disks = Disks(setting)
    assert [disks.names(n) for n in range(6)] == [(1, 2), (1, 3), (2, 3), (0, 1), (0, 2), (0, 3)]


def test_standing_robots_keep_their_static_gap():
    disks = Disks(scenario(((0.0, 0.0), (0.0, 0.0)), ((0.2, 0.0), (0.0, 0.0))))
    at = np.array([0.0 + 0j, 0.2 + 0j])
    assert np.allclose(gaps(disks, at, at), [0.12, 0.26, 0.06], atol=1e-15)
