"""Networks in a scenario: presets stand for what is not given, and what cannot be is named."""

from __future__ import annotations

import pytest

from protocol.errors import ScenarioError
from protocol.scenario.file import parse_document
from protocol.scenario.network import WIRELESS, Burst, Link

ROBOTS = [{"id": 1, "radius": 0.04, "start": [-0.2, 0.0], "goal": [0.2, 0.0]}]


@pytest.mark.parametrize("preset", WIRELESS)
def test_what_is_given_outranks_a_preset(preset: str) -> None:
    plain = parse_document({"robots": ROBOTS, "link": {"preset": preset}}).link
    for key, value in WIRELESS[preset].items():
        assert getattr(plain, key) == value
    given = {"preset": preset, "delay": 0.3, "burst": {"loss": 0.5}, "loss": 0.1}
    link = parse_document({"robots": ROBOTS, "link": given}).link
    assert (link.delay, link.burst, link.loss) == (0.3, Burst(loss=0.5), 0.1)
    assert link.roaming == plain.roaming


@pytest.mark.parametrize(
    ("link", "path", "text"),
    [
        ({"preset": "wifi"}, "link.preset", "good-wifi"),
        ({"burst": {"delay": [0.3, 0.1]}}, "link.burst.delay", "above the high end"),
        ({"burst": {"loss": 1.5}}, "link.burst.loss", "1"),
        ({"roaming": {"gap": -1.0}}, "link.roaming.gap", "at least 0"),
        ({"roaming": {"every": 2.0, "gap": [0.5, 3.0]}}, "link.roaming.gap", "longer than `every`, 2 s"),
        ({"capacity": 0}, "link.capacity", ""),
        ({"distance": {"los": 0.1}}, "link.distance.los", "loss"),
    ],
)
def test_what_no_network_is_is_named(link: dict[str, object], path: str, text: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        parse_document({"robots": ROBOTS, "link": link})
    assert [problem.path for problem in caught.value.problems] == [path]
    assert text in caught.value.problems[0].text


def test_without_a_network_nothing_is_added() -> None:
    assert parse_document({"robots": ROBOTS}).link == Link()
