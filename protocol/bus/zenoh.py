"""The bus on zenoh. The only module that imports it.

zenoh's threads only put events into one queue, and execute no Python for that, which would halve the rate of
a fleet. Everything else happens in `receive`, on the thread that owns the bus: a computing callback would be
starved by a busy main thread.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any, Final

import zenoh

from protocol.bus.bus import Event, Presence, Publish, Query, RawSample, Sample
from protocol.bus.connection import Connection, configuration
from protocol.errors import BusError, CertificateError, ListenError, UnservedError
from protocol.keys import Stream
from protocol.process.signals import STOP, Stopped

_ATTEMPT = 0.5  # s; a failed attempt reports its reason only at its end, so the first ones are short
_NEWS = 0.5  # s to wait for news that a key is served, before what may be repeated is sent all the same
_ASK_AGAIN = 0.02  # s between attempts
_OTHERS = 0.5  # s to wait for further answers
_TOKENS = 2.0  # s for routers to list their tokens
_LONGEST: Final = 3600.0  # s, longest single wait for the queue
_LINKING = 5.0  # s that a peer waits for its links before it announces itself
# Read by zenoh once, at the first session of a process: four threads instead of seven are faster.
_RUNTIME = "(rx:(worker_threads:1),acc:(handover:net),app:(handover:net),tx:(handover:net))"
# The end of a lost link to another router holds a receiving thread for up to 10 s, which then relays nothing.
_LINKED = "(rx:(worker_threads:16))"
_SETTLING = 0.15  # s, longer than zenoh waits from the loss of a link to another router to its new trees
# Unless RUST_LOG says otherwise, refused certificates are reported, but not that a link is tried again.
_ROUTER_LOG = "error,zenoh_link_tls=warn,zenoh_transport::unicast=off"
_CAPACITY: Final = 1 << 16

_KEPT: set[int] = set()  # threads of zenoh that Python keeps
_Arrived = zenoh.Sample | zenoh.Query | RawSample | Presence | None  # None: a signal came
_ZenohSample: Final = zenoh.Sample


class ZenohBus:
    """One zenoh session behind the `protocol.bus.bus.Bus` interface.

    Args:
        capacity: most waiting events; of more, only the newest half of this number are kept.

    Raises:
        ListenError: an endpoint of `connection.listen` is in use (EndpointTakenError), or not of this host.
        CertificateError: one end does not accept the other's certificate.
        BusError: no process could be reached within `connection.timeout`.
        Stopped: a signal asks this process to end; so does `ask`, and a wait for links.
    """

    def __init__(self, connection: Connection, capacity: int = _CAPACITY) -> None:
        self._queue: SimpleQueue[_Arrived] = SimpleQueue()
        self._wake = partial(self._queue.put, None)
        self._take: Callable[[], _Arrived] = self._queue.get_nowait  # looked up once
        self._there = 0  # last known number of waiting events, less those taken since
        self._declared: list[object] = []  # zenoh withdraws unreferenced declarations
        self._subscribed: dict[str, zenoh.Subscriber[None]] = {}  # by key expression
        self._connection, self._awaited = connection, False
        if connection.mode == "router":  # settings that precede the first session of a process
            zenoh.init_log_from_env_or(_ROUTER_LOG)
            if connection.connect or not all(each.is_loopback for each in connection.listen):
                os.environ["ZENOH_RUNTIME"] = _LINKED  # other hosts do not reach the loopback
        os.environ.setdefault("ZENOH_RUNTIME", _RUNTIME)
        self._session = _open(connection)
        if connection.mode == "router":
            settle = zenoh.handlers.Callback(_settle, indirect=False)
            self._declared.append(self._session.info.declare_transport_events_listener(settle))
        STOP.call(self._wake)
        self._capacity = capacity
        self.dropped = 0  # events lost to a full queue

    def publisher(self, stream: Stream, key: str) -> Publish:
        # Express messages would prevent batching, on which the rate depends.
        return self._publisher(key, waits=stream.reliable, express=False).put

    @property
    def identity(self) -> str:
        return str(self._session.info.zid())

    def raw_publisher(self, key: str, attach: Callable[[], bytes] | None = None) -> Publish:
        publisher = self._publisher(key, waits=False, express=True)  # a rare small message need not wait
        if attach is None:
            return publisher.put
        return lambda payload: publisher.put(payload, attachment=attach())

    def _publisher(self, key: str, *, waits: bool, express: bool) -> zenoh.Publisher:
        publisher = self._session.declare_publisher(
            key,
            congestion_control=zenoh.CongestionControl.BLOCK if waits else zenoh.CongestionControl.DROP,
            express=express,
            allowed_destination=zenoh.Locality.REMOTE,  # a bus does not receive its own samples
        )
        self._declared.append(publisher)
        return publisher

    def subscribe(self, *key_expressions: str) -> None:
        # A declared key is sent as a number, any other as text, which must be looked up.
        for each in key_expressions:
            handler = zenoh.handlers.Callback(self._queue.put, indirect=False)
            self._subscribed[each] = self._session.declare_subscriber(each, handler)

    def listen(self, key_expression: str) -> None:
        handler = zenoh.handlers.Callback(self._on_raw, indirect=False)
        self._declared.append(self._session.declare_subscriber(key_expression, handler))

    def unsubscribe(self, key: str) -> None:
        subscriber = self._subscribed.pop(key, None)
        if subscriber is not None:
            subscriber.undeclare()  # type: ignore[no-untyped-call]  # untyped in zenoh's stub

    def expect(self, keys: Iterable[str]) -> None:
        # The route of a declared key is kept; that of any other is looked up for every sample.
        self._declared += [self._session.declare_keyexpr(key) for key in keys]

    def bursts(self, key_expression: str) -> Callable[[], list[tuple[str, bytes]]]:
        """Subscribe to be read later: the function returned gives keys and payloads so far, of too many the
        newest. Nothing in Python wakes for a single sample, which is most of the cost."""
        ring: zenoh.handlers.RingChannel[zenoh.Sample] = zenoh.handlers.RingChannel(self._capacity)
        subscriber = self._session.declare_subscriber(key_expression, ring)
        self._declared.append(subscriber)
        return lambda: [
            (str(arrived.key_expr), arrived.payload.to_bytes()) for arrived in iter(subscriber.try_recv, None)
        ]

    def watch(self, key_expression: str) -> None:
        handler = zenoh.handlers.Callback(self._presence, indirect=False)
        self._declared.append(
            self._session.liveliness().declare_subscriber(key_expression, handler, history=True)
        )

    def serve(self, key: str) -> None:
        handler = zenoh.handlers.Callback(self._queue.put, indirect=False)
        self._declared.append(self._session.declare_queryable(key, handler, complete=True))

    def announce(self, key: str) -> None:
        # Without a router, samples published before a link is up are lost to that peer.
        if self._connection.mode == "peer" and not self._awaited:
            wanted, info = set(self._connection.connect), self._session.info
            _await(lambda: wanted <= {link.dst for link in info.links()}, _LINKING)  # one may stay down
            self._awaited = True
        self._declared.append(self._session.liveliness().declare_token(key))

    def ask(self, key: str, payload: bytes, timeout: float, *, once: bool = False) -> list[bytes]:
        deadline, served = time.monotonic() + timeout, False
        while (remaining := deadline - time.monotonic()) > 0.0:
            served |= self._is_served(key, remaining if once else min(_NEWS, 0.5 * remaining))
            if once and not served:
                break
            if replies := self._replies(key, payload, max(0.0, deadline - time.monotonic())):
                return replies
            if once:
                raise BusError(f"no answer under {key}: the process that serves it has ended, or is too slow")
            STOP.wait(_ASK_AGAIN)
        raise (BusError if served else UnservedError)(
            f"no answer under {key} within {timeout:g} s; is the process that serves it running, "
            f"under the same run name and reachable from the same endpoint?"
        )

    def _is_served(self, key: str, timeout: float) -> bool:
        """Whether zenoh reports, within `timeout` s, that a process serves `key`."""
        with self._session.declare_querier(key) as declared:
            querier: Any = declared  # zenoh's stub takes its status for a bool
            return _await(lambda: bool(querier.matching_status.matching), timeout)

    def _replies(self, key: str, payload: bytes, timeout: float) -> list[bytes]:
        """Those of all that serve `key`. A frozen process is not waited for once another has answered."""
        arrived: SimpleQueue[zenoh.Reply | None] = SimpleQueue()
        end = partial(arrived.put, None)
        replies: list[bytes] = []
        with STOP.calling(end), suppress(Empty):
            self._session.get(
                key,
                zenoh.handlers.Callback(arrived.put, end, indirect=False),
                payload=payload,
                timeout=timeout,
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
            )
            while (reply := arrived.get(True, _OTHERS if replies else timeout + _OTHERS)) is not None:
                if reply.ok is not None:
                    replies.append(reply.ok.payload.to_bytes())
        STOP.check()
        return replies

    def post(self, key: str, payload: bytes) -> None:
        handler = zenoh.handlers.Callback(self._on_reply, indirect=False)
        self._session.get(key, handler, payload=payload, timeout=_LINKING, target=zenoh.QueryTarget.ALL)

    def tokens(self, key_expression: str) -> list[str]:
        replies = self._session.liveliness().get(key_expression, timeout=_TOKENS)
        return [str(reply.ok.key_expr) for reply in replies if reply.ok is not None]

    def receive(self, timeout: float) -> Event | None:
        if not self._there:
            self._there = self._count()
        if self._there:  # the usual case, and the quicker call
            self._there -= 1
            arrived = self._take()
        elif timeout > 0.0:
            try:
                arrived = self._queue.get(True, min(timeout, _LONGEST))
            except Empty:
                return None
        else:
            return None
        if isinstance(arrived, _ZenohSample):
            return Sample(str(arrived.key_expr), arrived.payload.to_bytes())
        if isinstance(arrived, zenoh.Query):
            return _request(arrived)
        return arrived

    def close(self) -> None:
        STOP.call_no_more(self._wake)
        self._session.close()  # type: ignore[no-untyped-call]  # untyped in zenoh's stub
        self._declared.clear()
        self._subscribed.clear()

    def await_routers(self, timeout: float) -> None:
        """As a router, wait for a link to every router that this one connects to, `timeout` s at most; raises
        BusError."""
        wanted, info = self._connection.connect, self._session.info
        if not _await(lambda: len(list(info.routers_zid())) >= len(wanted), timeout):
            raise BusError(
                f"linked with {len(list(info.routers_zid()))} of {len(wanted)} routers within {timeout:g} s; "
                f"can all of {', '.join(wanted)} be reached from this host?"
            )

    def _count(self) -> int:
        """Number of waiting events, after the oldest of too many are dropped."""
        waiting = self._queue.qsize()
        if waiting <= self._capacity:
            return waiting
        excess = waiting - self._capacity // 2
        for _ in range(excess):
            self._take()
        self.dropped += excess
        return waiting - excess

    def _on_raw(self, sample: zenoh.Sample) -> None:
        _keep_thread_state()
        attachment = sample.attachment
        beside = b"" if attachment is None else attachment.to_bytes()
        self._queue.put(RawSample(str(sample.key_expr), sample.payload.to_bytes(), beside))

    def _on_reply(self, reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            self._on_raw(reply.ok)

    def _presence(self, sample: zenoh.Sample) -> None:
        _keep_thread_state()
        self._queue.put(Presence(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT))


def _keep_thread_state() -> None:
    """Keep Python's state of this zenoh thread for ever; otherwise it is created for every sample."""
    thread = threading.get_native_id()
    if thread not in _KEPT:
        _KEPT.add(thread)
        ctypes.pythonapi.PyGILState_Ensure()


def _settle(event: zenoh.TransportEvent) -> None:
    """Hold up the end of a link to another router until zenoh has new trees. If the link returned before
    them, zenoh would never again tell that router what this one receives.
    """
    if event.kind == zenoh.SampleKind.DELETE and event.transport.whatami == zenoh.WhatAmI.ROUTER:
        time.sleep(_SETTLING)


def _await(there: Callable[[], bool], timeout: float) -> bool:
    """Wait until `there` is true, `timeout` s at most; returns whether it is."""
    deadline = time.monotonic() + timeout
    while not (is_there := there()) and time.monotonic() < deadline:
        STOP.check()
        time.sleep(0.005)
    return is_there


def _request(query: zenoh.Query) -> Query:
    payload = query.payload
    return Query(str(query.key_expr), b"" if payload is None else payload.to_bytes(), partial(_reply, query))


def _reply(query: zenoh.Query, payload: bytes) -> None:
    with query:  # its end ends the wait of the requester
        query.reply(query.key_expr, payload)


def _open(connection: Connection) -> zenoh.Session:
    deadline, patience = time.monotonic() + connection.timeout, _ATTEMPT
    while True:
        attempt = min(patience, max(0.1, deadline - time.monotonic()))
        patience *= 2.0  # a busy machine may need longer
        config = zenoh.Config.from_json5(json.dumps(configuration(connection, attempt)))
        try:
            return _opened(config)
        except zenoh.ZError as error:
            from protocol.bus.diagnose import explained  # it imports ssl, which a robot does not need

            failure = explained(connection, str(error))
            if isinstance(failure, ListenError | CertificateError) or time.monotonic() >= deadline:
                raise failure from error


def _opened(config: zenoh.Config) -> zenoh.Session:
    """Open a session on a separate thread, which leaves signals to the main thread, as do those that zenoh
    starts in it. Otherwise a frozen process may receive SIGTERM in any thread, and Python notices it late.
    """
    outcome: SimpleQueue[zenoh.Session | BaseException | None] = SimpleQueue()
    given_up = threading.Event()

    def attempt() -> None:
        signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        try:
            session = zenoh.open(config)
        except BaseException as error:  # noqa: BLE001  # raised where it is waited for
            outcome.put(error)
        else:
            outcome.put(session)
            if given_up.is_set():
                session.close()  # type: ignore[no-untyped-call]  # untyped in zenoh's stub

    threading.Thread(target=attempt, name="open").start()
    with STOP.calling(partial(outcome.put, None)):
        opened = outcome.get()
    if isinstance(opened, BaseException):
        raise opened
    if opened is None:
        given_up.set()
        raise Stopped
    return opened
