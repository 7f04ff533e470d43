"""Three linked routers, whose links are lost and return at once."""

import socket
import time
from contextlib import closing
from select import select
from threading import Event, Thread

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


def relay(port: int, to: int, cut: Event) -> None:
    """Relay one TCP connection after another, each until it ends or is cut."""
    with socket.create_server(("127.0.0.1", port)) as server:
        while True:
            with server.accept()[0] as near, socket.create_connection(("127.0.0.1", to)) as far:
                cut.clear()
                other, data = {near: far, far: near}, b"some"
                while data and not cut.is_set():
                    for end in select([near, far], [], [], 0.02)[0]:
                        if data := end.recv(1 << 16):
                            other[end].sendall(data)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")  # at the end
@pytest.mark.process
@pytest.mark.timeout(90)
@pytest.mark.long(10)
def test_what_a_link_carried_it_carries_again() -> None:
    ports, cut = free_ports(5), (Event(), Event())
    first, second, third, *relays = (Endpoint(f"tcp/127.0.0.1:{port}") for port in ports)
    for port, event in zip(ports[3:], cut, strict=True):
        Thread(target=relay, args=(port, ports[0], event), daemon=True).start()
    with Supervisor(spawner()) as supervisor:
        for name, own, *others in ("1", first), ("2", second, relays[0]), ("3", third, relays[1], second):
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

            for _ in range(16):
                links_are_back = time.monotonic() + 0.6
                until(lambda moment=links_are_back: hears(moment), 10.0, "a link is lost for ever")
                for event in cut:
                    event.set()
