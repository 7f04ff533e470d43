"""Three linked routers, whose links are lost and return at once."""

import socket
import time
from contextlib import closing, suppress
from select import select
from threading import Thread

import pytest

from deploy.processes import table
from deploy.processes.supervisor import Supervisor
from protocol.bus.connection import Connection, Endpoint
from protocol.bus.zenoh import ZenohBus
from protocol.keys import STREAMS, world_key
from tests.deploy.processes.children import spawner
from tests.deploy.processes.ports import free_ports
from tests.until import until

KEY = world_key("yard", "truth")


def relay(port: int, to: int, ends: list[socket.socket]) -> None:
    """Relay one TCP connection after another, until its near end closes; `ends` are those that are open."""
    with socket.create_server(("127.0.0.1", port)) as server:
        while True:
            with server.accept()[0] as near, socket.create_connection(("127.0.0.1", to)) as far:
                ends[:] = near, far
                other = {near: far, far: near}
                while near in ends:
                    for end in select(ends, [], [])[0]:
                        if not (data := end.recv(1 << 16)):
                            ends.remove(end)
                        with suppress(OSError):  # it is shut down
                            other[end].sendall(data)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")  # at the end
@pytest.mark.process
@pytest.mark.timeout(90)
@pytest.mark.long(6)
def test_what_a_link_carried_it_carries_again() -> None:
    ports, links = free_ports(6), list[list[socket.socket]]([[], [], []])
    first, second, third, *relays = (Endpoint(f"tcp/127.0.0.1:{port}") for port in ports)
    for port, to, ends in zip(ports[3:], (ports[0], ports[0], ports[1]), links, strict=True):
        Thread(target=relay, args=(port, to, ends), daemon=True).start()
    with Supervisor(spawner()) as supervisor:
        for name, own, *others in ("1", first), ("2", second, relays[0]), ("3", third, *relays[1:]):
            supervisor.start([table.router(Connection("router", tuple(others), (own,)), host=name)])
            supervisor.report(f"router-{name}", 20.0)
        with (
            closing(ZenohBus(Connection(connect=(first,)))) as there,
            closing(ZenohBus(Connection(connect=(second,)))) as here,
        ):
            tell, heard = there.publisher(STREAMS["truth"], KEY), here.bursts(KEY)

            def hears(moment: float) -> bool:
                tell(str(time.monotonic()).encode())
                return any(float(payload) >= moment for _, payload in heard())

            for _ in range(4):
                links_are_there = time.monotonic() + 0.6
                until(lambda moment=links_are_there: hears(moment) and min(map(len, links)) == 2, 10.0)
                (near, far), (back, other), (beside, _) = links
                beside.shutdown(socket.SHUT_RDWR)  # for 0.1 s after that zenoh makes no trees
                # The first router loses both links before either returns; others know of one loss each.
                for end in far, other:
                    end.shutdown(socket.SHUT_WR)
                until(lambda one=[near], two=[back]: links[:2] == [one, two])
                near.shutdown(socket.SHUT_RDWR)
                links_are_back = time.monotonic() + 0.1
                until(lambda moment=links_are_back: hears(moment), 10.0, "a link is lost for ever")
                back.shutdown(socket.SHUT_RDWR)
