"""Replaying: the same trajectory recomputed, the same messages over again, and what `info` says."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deploy.cli.recording import _check, info, replay
from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.telemetry.plot import draw
from deploy.telemetry.recording.reader import Recording, read
from deploy.telemetry.recording.replay import participants, publish, published, verify
from protocol.bus.local import LocalNetwork
from protocol.codec import decode
from protocol.errors import RecordingError
from protocol.keys import everything
from protocol.messages import Result, State, Tick
from protocol.scenario.model import Order, RobotSpec, Scenario
from tests.deploy.telemetry.recording.recorded import rewritten, said_by
from tests.listening import overhear


def _without_truths(recording: Recording, lost: set[int]) -> Recording:
    whole = recording.trajectory
    return replace(recording, trajectory=whole.at(~np.isin(whole.ticks, list(lost))))


def test_lost_truths_are_worked_out_from_measurements_to_the_last_bit(recording):
    last = int(recording.trajectory.ticks[-1])
    found = verify(_without_truths(recording, {5, 6, 20, last}))
    assert found == (recording.result["trajectory_sha256"], 3)
    assert found.remark == " (3 ticks reconstructed from odometry)"
    every = _without_truths(recording, set(range(1, last + 1)))
    assert verify(every) == (recording.result["trajectory_sha256"], last - 1)


def test_an_unknown_tick_is_an_error_of_its_own(recording):
    lost = said_by(recording, Tick, 2)[5]
    known = recording.entries.where(lambda entry: entry.message != lost)
    said = "the Truth of tick 5 was not recorded, nor the odometry of robot 2"
    with pytest.raises(RecordingError, match=said):
        verify(_without_truths(replace(recording, entries=known), {5}))


def test_without_a_result_there_is_nothing_to_compare(recording):
    assert verify(replace(recording, result=None)) is None
    of_a_lost_world = recording.result | {"positions": None, "trajectory_sha256": None}
    assert verify(replace(recording, result=of_a_lost_world)) is None
    assert "no result to compare with" in _check(replace(recording, result=of_a_lost_world))


def test_everything_is_published_again_in_order(recording):
    times, samples = zip(*published(recording), strict=True)
    assert list(times) == sorted(times)
    assert len(samples) == recording.counts.total() + 1
    for said, entry in zip(samples, recording.entries, strict=False):
        assert (said.key, decode(said.key, said.payload)) == (entry.key, entry.message)
    assert isinstance(decode(samples[-1].key, samples[-1].payload), Result)


def test_a_recording_is_heard_under_another_name(recording):
    network, heard = LocalNetwork(), []
    listener = overhear(network, lambda *said: heard.append(said), everything("again"))
    publish(recording, network.connect(), "again", speed=0.0)
    listener.drain()
    assert heard == [(sample.key, sample.payload) for _, sample in published(recording, "again")]


def test_commands_say_what_they_found(recording, tmp_path, capsys):
    path = recording.path
    replay(path)
    assert "as in the result" in capsys.readouterr().out
    info(path)
    said = capsys.readouterr().out
    for word in ("three, 3 robots", recording.result["verdict"], "complete", "disknav/three/robot/7/state"):
        assert word in said
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    info(cut)
    assert "cut short" in capsys.readouterr().out


@pytest.mark.process
def test_exit_status_of_the_command(recording, disknav, tmp_path):
    x = repr(recording.trajectory.positions[20, 0, 0].item()).encode()
    other = x[:-1] + (b"1" if x[-1:] != b"1" else b"2")
    altered = rewritten(recording.path, tmp_path / "altered.mcap", lambda data: data.replace(x, other))
    said = "altered.mcap: the recorded trajectory has hash"
    none = tmp_path / "none.mcap"
    for file, status, text in ((recording.path, 0, ""), (altered, 3, said), (none, 2, "No such file")):
        done = disknav("recording", "replay", file)
        assert done.returncode == status, done.stderr
        assert text in done.stderr


# -- robots that come and go


GUEST = RobotSpec(5, 0.03, (0.0, 0.0), (0.0, 0.2))
ORDERS = (Order(0.2, add=GUEST), Order(1.0, remove=2))


def run_recorded(scenario: Scenario, path: Path) -> Recording:
    with LocalFleet(scenario, record=path) as fleet:
        fleet.execute()
    return read(path)


@pytest.fixture(scope="module")
def guested(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    course = replace(load("swap-3", ["time.limit=3.0"]), orders=ORDERS)
    return run_recorded(course, tmp_path_factory.mktemp("recorded") / "come.mcap")


def there(recording: Recording, robot: int) -> list[int]:
    index = recording.trajectory.robots.tolist().index(robot)
    return recording.trajectory.ticks[~np.isnan(recording.trajectory.positions[:, index, 0])].tolist()


def test_each_is_where_it_was_while_it_was_there(guested: Recording) -> None:
    last = int(guested.trajectory.ticks[-1])
    assert guested.trajectory.robots.tolist() == [1, 2, 3, 5]
    assert there(guested, 1) == list(range(last + 1))
    assert there(guested, 2) == list(range(21))
    assert there(guested, 5)[0] > 4
    assert there(guested, 5)[-1] == last
    assert said_by(guested, State, 5)


def test_a_lost_truth_is_worked_out_unless_somebody_came_or_went(guested: Recording) -> None:
    found = verify(_without_truths(guested, {30}))
    assert (found.sha256, found.restored) == (guested.result["trajectory_sha256"], 1)
    with pytest.raises(RecordingError, match="robots appeared or left before tick 22"):
        verify(_without_truths(guested, {21}))


@pytest.mark.slow
def test_a_robot_that_takes_up_a_part_leaves_the_trajectory_the_results(tmp_path: Path) -> None:
    recording = run_recorded(load("parts-3"), tmp_path / "parts.mcap")
    assert verify(recording) == (recording.result["trajectory_sha256"], 0)


def test_participants_have_what_is_known_of_them(guested: Recording) -> None:
    found = {each.robot: each for each in participants(guested)}
    assert (found[5].radius, found[5].goal) == (GUEST.radius, GUEST.goal)
    assert found[5].known[0] == pytest.approx(GUEST.start)
    operated = replace(guested, scenario=replace(guested.scenario, orders=()))
    (guest,) = (each for each in participants(operated) if each.robot == 5)
    assert (guest.radius, guest.goal) == (GUEST.radius, None)  # by the roster, which has no goals
    assert [each.robot for each in participants(draw.until(guested, 0.1))] == [1, 2, 3]
