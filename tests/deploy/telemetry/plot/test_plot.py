"""Pictures: every format, what they show, and what is refused before a run is wasted on it."""

import math
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image
from PIL import Image

from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.telemetry.plot.draw import check, draw, until
from deploy.telemetry.plot.figure import measurement_ages, state_ages
from deploy.telemetry.plot.workspace import COLOURS, colour, dash, stays
from deploy.telemetry.recording.reader import Recording, read
from protocol.errors import UsageError
from protocol.scenario.model import Obstacle, Sensing
from protocol.scenario.network import Link
from tests.deploy.telemetry.recording.recorded import record
from tests.system.orders.turnover import asked, step

pytestmark = pytest.mark.slow

STEP = 0.05


@pytest.fixture(scope="module")
def faulty(tmp_path_factory) -> Recording:
    """Measurements two ticks late, States three ticks late and two in five lost."""
    path = tmp_path_factory.mktemp("plot") / "faulty.mcap"
    record(path, sensing=(Sensing(delay=0.1),), link=Link(delay=0.15, loss=0.4))
    return read(path)


def test_a_picture_shows_every_robot_and_the_words(recording, tmp_path):
    draw(recording, tmp_path / "a.png")
    pixels = (image.imread(tmp_path / "a.png")[:, :, :3] * 255).round().astype(int).reshape(-1, 3)
    for index, _ in enumerate(recording.scenario.ids):
        wanted = [int(colour(index)[place : place + 2], 16) for place in (1, 3, 5)]
        assert (np.abs(pixels - wanted).max(axis=1) < 8).sum() > 50, f"nothing is drawn in {colour(index)}"
    for name in ("a.svg", "b.svg"):
        draw(recording, tmp_path / name)
    text = (tmp_path / "a.svg").read_text()
    assert text == (tmp_path / "b.svg").read_text()  # the same recording gives the same file
    for word in (f"three: {recording.result['verdict']}", "clearance, mm", "γ", "start", "goal", ">7<"):
        assert word in text


def test_an_excerpt_ends_where_it_was_cut(recording, tmp_path):
    part = until(recording, 3.2 * STEP)
    assert part.trajectory.ticks.tolist() == [0, 1, 2, 3]
    assert len(part.trajectory.positions) == len(part.trajectory.phi) == len(part.trajectory.clearance) == 4
    assert max(entry.time for entry in part.entries) <= 3.5 * STEP
    assert len(until(recording, 0.0).trajectory.ticks) == 1
    assert until(recording, 1e9) is recording
    draw(part, tmp_path / "a.svg")
    assert "three: the first 0.2 s" in (tmp_path / "a.svg").read_text()


def test_a_run_cut_before_anything_happened_can_be_drawn(recording, tmp_path):
    data = recording.path.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: data.index(b"scenario") + 3000])
    begun = read(cut)
    assert begun.trajectory.ticks.tolist() == [0]
    draw(begun, tmp_path / "a.gif", width=200, seconds=1.0)
    assert (tmp_path / "a.gif").stat().st_size > 1000


@pytest.mark.parametrize("name", ["a.gif", pytest.param("a.webp", marks=pytest.mark.campaign)])
def test_an_animation_ends_with_the_end(recording, tmp_path, name):
    told: list[float] = []
    draw(recording, tmp_path / name, told.append, width=200, seconds=1.0)
    assert told == sorted(told)
    assert 0.9 < told[-1] < 1.0
    with Image.open(tmp_path / name) as film:
        assert film.format == name[2:].upper()
        assert film.width == 200
        assert film.n_frames > 10


def test_colours_and_dashes_tell_robots_apart():
    looks = {(colour(index), dash(index)) for index in range(24)}
    assert len(looks) == 24
    luminance = sorted(
        0.299 * int(each[1:3], 16) + 0.587 * int(each[3:5], 16) + 0.114 * int(each[5:7], 16)
        for each in COLOURS
    )
    assert luminance[-1] < 190, "too pale for white paper"
    neighbours = [dash(index) != dash(index + 1) for index in range(23)]
    assert all(neighbours), "in grey, robots next to each other look alike"


def test_an_obstacle_is_shown_from_when_until_when_it_is_there(tmp_path):
    listed = replace(load("swap-4"), obstacles=(Obstacle(center=(0.2, 0.2), radius=0.02),))
    with LocalFleet(listed, record=tmp_path / "run.mcap", speed=20.0) as fleet:
        for change in ({"place": {"center": [0.0, 0.0], "radius": 0.01}}, {"take": 1}):
            step(fleet, 20)
            assert asked(fleet, change).accepted
        step(fleet, 20)
        fleet.world.interrupt("interrupted", "enough")
        fleet.execute()
    first, second = stays(read(tmp_path / "run.mcap"))
    assert (first.since, second.until) == (0.0, math.inf)
    assert 0.9 < second.since < 1.5 < first.until < 3.0
    assert second.words == f"from {second.since:.1f} s"


# -- ages


def test_age_of_measurements_is_the_injected_delay(faulty):
    ticks, ages = measurement_ages(faulty)
    assert np.isnan(ages[:2]).all()
    assert np.allclose(ages[2 : ticks[-1]], 0.1)


def test_age_of_states_is_the_injected_delay_at_least_and_grows_with_loss(faulty):
    _, ages, lost = state_ages(faulty)
    known = ages[~np.isnan(ages)]
    assert known.min() == pytest.approx(0.15)
    assert known.max() > 0.2
    assert lost == pytest.approx(0.4, abs=0.1)


# -- refusals


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.bmp", "name one that ends in .png"),
        ("a", "name one that ends in .png"),
        ("no/a.png", "No such file or directory; name a file that can be written"),
    ],
)
def test_what_cannot_be_drawn_is_refused(tmp_path, name, text):
    with pytest.raises(UsageError, match=text):
        check(tmp_path / name)


def test_without_matplotlib_the_install_line_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(UsageError, match=r"matplotlib.*pip install .*\[plot\]"):
        check(tmp_path / "a.png")


def test_without_ffmpeg_a_film_is_a_gif(monkeypatch, recording, tmp_path: Path):
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(UsageError, match=r"needs ffmpeg.*or name a \.gif"):
        draw(recording, tmp_path / "a.mp4")


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="needs ffmpeg, from the package of that name")
def test_a_film_for_players_everywhere(recording, tmp_path):
    """Every player wants H.264 in yuv420p; the disks of the last picture are in their colours."""
    draw(recording, tmp_path / "a.mp4")
    assert (tmp_path / "a.mp4").read_bytes()[4:8] == b"ftyp"
    frame = tmp_path / "last.png"
    subprocess.run(
        ["ffmpeg", "-v", "error", "-sseof", "-0.5", "-i", tmp_path / "a.mp4", "-frames:v", "1", frame],
        check=True,
        timeout=30,
    )
    pixels = (image.imread(frame)[:, :, :3] * 255).round().astype(int).reshape(-1, 3)
    assert (pixels.min(axis=1) > 240).mean() > 0.5, "the background is not white"
    for index, _ in enumerate(recording.scenario.ids):
        tint = [round(0.6 * int(colour(index)[place : place + 2], 16) + 0.4 * 255) for place in (1, 3, 5)]
        assert (np.abs(pixels - tint).max(axis=1) < 24).sum() > 50, f"no disk in {colour(index)}"
