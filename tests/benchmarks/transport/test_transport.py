"""The floors tick, and a model of links is found again. Nothing is timed here."""

from __future__ import annotations

from typing import Literal

import pytest

from protocol.scenario.model import Network
from tests.benchmarks.links import in_blocks
from tests.benchmarks.transport import link_model, meshes
from tests.benchmarks.transport.bare import rate


@pytest.mark.process
@pytest.mark.timeout(60)
@pytest.mark.parametrize("bus", ["raw", "bus"])
def test_bare_ticks(bus: Literal["raw", "bus"]) -> None:
    measured = rate(3, 0.2, bus)
    assert measured.ticks_per_second > 0.0
    assert measured.cpu_ms >= 0.0


@pytest.mark.process
@pytest.mark.timeout(60)
@pytest.mark.parametrize("carrier", ["zmq", "pipes"])
def test_floors_tick(carrier: meshes.Carrier) -> None:
    if carrier == "zmq":
        pytest.importorskip("zmq")
    assert meshes.rate(3, 0.1, carrier).ticks_per_second > 0.0


def test_a_model_of_links_is_found_again() -> None:
    loads = [link_model.load(in_blocks(12, hosts, 1.0, Network("near")), hosts) for hosts in (2, 3, 4)]
    found = link_model.fitted(loads, [each.bytes(200.0, 150.0) for each in loads])
    assert found == pytest.approx((200.0, 150.0))
