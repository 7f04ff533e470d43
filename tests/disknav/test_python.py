"""`import disknav`: scenarios in, arrays out, and the same trajectory as the command's."""

from hashlib import sha256
from pathlib import Path

import numpy as np
import pandas
import polars
import pytest

import disknav
from deploy.run.local import LocalFleet
from protocol.errors import UsageError
from protocol.scenario.file import write_toml
from world.judge.record import trajectory_rows

ROBOTS = [
    {"id": 7, "radius": 0.04, "start": np.array([-0.2, 0.0]), "goal": (0.2, 0.0)},
    {"id": 2, "radius": np.float64(0.04), "start": [0.0, -0.2], "goal": [0.0, 0.2]},
]


def test_settings_are_as_on_the_command_line() -> None:
    scenario = disknav.load(
        "swap-3",
        {"control.k": np.int64(80), "control.additions": ["escape"], "robots[0].goal": (0.1, 0.0)},
        seed=5,
    )
    assert (scenario.control.k, scenario.control.additions, scenario.seed) == (80, ("escape",), 5)
    assert disknav.load("swap-3", {"control.k": np.float32(80), "name": "yard"}).k == 80.0
    assert scenario.robots[0].goal == (0.1, 0.0)
    assert disknav.load("swap-3", {"link": {"delay": [0, 0.1]}}).link.delay == (0.0, 0.1)
    with pytest.raises(disknav.ScenarioError, match="must be a finite number"):
        disknav.load("swap-3", {"control.k": float("nan")})
    for refused in (["control.k=80"], "control.k=80"):
        with pytest.raises(UsageError, match="give a dictionary"):
            disknav.load("swap-3", refused)  # type: ignore[arg-type]
        with pytest.raises(UsageError, match="give a dictionary"):
            disknav.build(refused)  # type: ignore[arg-type]


def test_every_problem_is_named() -> None:
    with pytest.raises(disknav.ScenarioError) as caught:
        disknav.build({"robots": [{**ROBOTS[0], "radius": -1.0}], "control": {"law": 3, "rush": True}})
    assert {problem.path for problem in caught.value.problems} == {
        "control.law",
        "control.rush",
        "robots[0].radius",
    }


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"control": {"k": "certified"}}, "for scenario files and names of the library"),
        ({"seed": 1j}, "complex"),
    ],
)
def test_what_cannot_be_built_is_refused(settings: dict[str, object], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        disknav.build({"robots": ROBOTS, **settings})


def test_seeds_and_points_of_numpy_are_numbers(tmp_path: Path) -> None:
    file = tmp_path / "two.toml"
    file.write_text(write_toml(disknav.build({"robots": ROBOTS, "seed": np.int64(3)})))
    assert disknav.load(file).seed == 3
    assert disknav.load(file, seed=np.int64(2)) == disknav.load(file, seed=2)
    assert disknav.load("random-6", seed=np.arange(3)[2]) == disknav.load("random-6", seed=2)
    simulation = disknav.Simulation("swap-6")
    orders = simulation.orders
    assert simulation.step()
    assert orders.send(np.int64(3), np.array([0.0, 0.0]), within=np.float32(5.0)) == 1
    assert orders.status(np.uint8(3)).goal == (0.0, 0.0)
    number = orders.place(np.array([0.1, 0.2]), radius=np.float64(0.01))
    orders.take(np.int32(number))


def test_a_simulation_takes_what_a_run_takes() -> None:
    simulation = disknav.Simulation("swap-3", {"control.k": 80}, seed=5)
    assert simulation.scenario == disknav.load("swap-3", {"control.k": 80}, seed=5)
    assert simulation.step()
    with pytest.raises(UsageError, match="load or build"):
        disknav.Simulation(simulation.scenario, seed=1)
    with pytest.raises(disknav.DisknavError, match="run name"):
        disknav.Simulation("swap-3", name="a/b")
    with pytest.raises(UsageError, match="has the file already"):
        disknav.run("swap-3", record="swap-3")


@pytest.mark.slow
def test_a_run_is_the_worlds_truth() -> None:
    scenario = disknav.build({"robots": ROBOTS})
    run = disknav.run(scenario)
    report = LocalFleet(scenario).execute()
    trajectory = run.trajectory
    assert run.arrived
    assert run.result["trajectory_sha256"] == report["trajectory_sha256"]
    rows = trajectory_rows(scenario.ids, trajectory.ticks.tolist(), trajectory.positions)
    assert sha256(rows).hexdigest() == report["trajectory_sha256"]
    assert trajectory.robots.tolist() == [2, 7]
    assert np.array_equal(trajectory.of_robot(7)[0], [-0.2, 0.0])
    assert trajectory.clearance.min() == report["min_clearance"]
    assert trajectory.phi[-1] == report["phi"]["last"]
    assert trajectory.times[-1] == pytest.approx(report["sim_time"])
    with pytest.raises(UsageError, match="no robot 3; there are 2, 7"):
        trajectory.of_robot(3)


def test_a_simulation_goes_on_by_one_tick() -> None:
    simulation = disknav.Simulation(disknav.build({"robots": ROBOTS}))
    start = simulation.positions
    assert simulation.tick == 0
    assert simulation.step()
    assert (simulation.tick, simulation.time) == (1, 0.05)
    moved = np.hypot(*(simulation.positions - start).T)
    assert (moved > 0).all()
    assert (moved <= 0.05 * 0.10 * (1 + 1e-9)).all()
    rest = list(simulation)
    assert simulation.verdict == "arrived"
    assert len(rest) == simulation.tick - 1 == len(simulation.trajectory.ticks) - 2
    assert not simulation.step()


@pytest.mark.slow
def test_columns_and_frames_say_the_same() -> None:
    trajectory = disknav.run(disknav.build({"robots": ROBOTS})).trajectory
    columns = trajectory.columns()
    for frame in (pandas.DataFrame(columns), polars.DataFrame(columns)):
        assert list(frame.columns) == list(columns)
        assert all(np.array_equal(frame[name].to_numpy(), values) for name, values in columns.items())
    row = 2 * 9 + 1
    assert (columns["tick"][row], columns["robot"][row]) == (9, 7)
    assert (columns["x"][row], columns["y"][row]) == tuple(trajectory.positions[9, 1])


@pytest.mark.process
def test_a_fleet_drives_the_same_and_is_recorded(tmp_path: Path) -> None:
    scenario = disknav.build({"robots": ROBOTS, "link": {"delay": [0.0, 0.1]}})
    here = disknav.run(scenario)
    fleet = disknav.run(scenario, transport="routed", record=tmp_path / "run.mcap")
    assert fleet.result["trajectory_sha256"] == here.result["trajectory_sha256"]
    assert {row["name"] for row in fleet.result["processes"]} >= {"world", "robot-2", "robot-7"}
    recording = disknav.read(tmp_path / "run.mcap")
    assert recording.result == fleet.result
    assert np.array_equal(recording.trajectory.positions, fleet.trajectory.positions)
    commands, states = recording.columns("command"), recording.columns("state")
    ticks = [tick for tick in range(fleet.result["ticks"]) for _ in ROBOTS]
    for columns in (commands, states):
        assert set(columns["robot"].tolist()) == {2, 7}
        assert sorted(columns["tick"].tolist()) == ticks
    speeds = np.hypot(commands["velocity_x"], commands["velocity_y"])
    assert 0.05 < speeds.max() <= 0.10 * (1 + 1e-9)
    own = states["robot"] == 7
    assert states["gamma"][own][0] == pytest.approx(0.16)
    assert recording.columns("health")["rejected"][0] == {}
    with pytest.raises(UsageError, match=r"no stream 'velocity'; there are .*command"):
        recording.columns("velocity")
