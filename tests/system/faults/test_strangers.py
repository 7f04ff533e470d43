"""Messages of strangers under a run's name end no process: they are counted and dropped."""

import json
from contextlib import ExitStack

import pytest

from deploy.library.load import load
from deploy.processes import table
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from deploy.run.result import unjudged
from protocol.bus.bus import RawSample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import encode
from protocol.joining import Refusal, decode_reply
from protocol.keys import STREAMS
from protocol.messages import Clock, Result
from protocol.scenario.model import Scenario

TOKENS = tuple(f"robot/{robot}/alive/5c1f" for robot in ("0", "x", "01", "7", "999999999"))
PATTERNS = ("**", "world/*", "world/**")
HUGE = b"\xc1" * (1 << 20)


class Disturbed(Fleet):
    """A fleet that a stranger on the same network talks to before and while it runs."""

    def __init__(self, scenario: Scenario, options: RunOptions) -> None:
        super().__init__(scenario, options, watch=self._disturb)
        self.replies: list[object] = []

    def _listen(self, stack: ExitStack) -> None:
        super()._listen(stack)
        stranger = ZenohBus(Connection(connect=(self._options.router,)))
        self.close = stranger.close
        prefix = f"disknav/{self._options.run}"
        for token in (*TOKENS, "robot/1/alive", "robot/2/alive/3/4/5"):
            stranger.announce(f"{prefix}/{token}")
        self.replies.append(decode_reply(stranger.ask(f"{prefix}/robot/1/join", b"?", 20.0)[0]))
        for pattern in PATTERNS:
            stranger.post(f"{prefix}/{pattern}", b"?")
            heard = stranger.receive(20.0)
            self.replies.append(decode_reply(heard.payload) if isinstance(heard, RawSample) else heard)
        keys = ("robot/1/state", "robot/1/command", "robot/*/command", "robot/1/tick", "world/clock")
        keys += ("world/scenario", "world/result", "robot/1/2/3/4/5/state", "robot/0/state")
        self._say = [stranger.publisher(STREAMS["clock"], f"{prefix}/{key}") for key in keys]
        self._judge = stranger.publisher(STREAMS["result"], f"{prefix}/world/result")

    def _disturb(self, clock: Clock) -> None:
        for say in self._say:
            say(b"\x91\xa7state/2")
        report = unjudged(self._scenario, clock, 0.0) | {"verdict": "aborted"}
        self._judge(encode(Result(json.dumps(report))))
        if clock.tick < 20:
            self._say[0](HUGE)


@pytest.mark.process
@pytest.mark.timeout(150)
def test_a_stranger_on_an_open_network_ends_no_process() -> None:
    scenario = load("swap-2")
    with Supervisor() as supervisor:
        supervisor.start([table.router(Connection("router"))])
        router = supervisor.report("router", 20.0)
        with Disturbed(scenario, RunOptions(router=router, speed=4.0)) as fleet:
            report = fleet.execute()
            fleet.close()
    assert all(isinstance(reply, Refusal) for reply in fleet.replies), fleet.replies
    assert report["verdict"] == "arrived"
    assert report["trajectory_sha256"] == LocalFleet(scenario).execute()["trajectory_sha256"]
    rejected = report["messages"]["rejected"]
    assert rejected["identity"] >= 2  # tokens of robots that there are not
    assert rejected["key"] >= 3  # tokens and requests under no key of the protocol
    assert rejected["shape"] > 0
