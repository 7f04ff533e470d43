"""A real ROS 2 for tests, from the package registry: an environment of its own, kept in `build/`."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGES = (
    "ros-jazzy-rclpy",
    "ros-jazzy-rmw-fastrtps-cpp",
    "ros-jazzy-geometry-msgs",
    "ros-jazzy-nav-msgs",
    "mujoco",
    "eclipse-zenoh",
)
HERE = Path(__file__).parent
FOLDER = HERE.parents[3] / "build" / "ros2"
NEEDED = "import rclpy, geometry_msgs.msg, nav_msgs.msg, mujoco, zenoh; rclpy.init()"


def environment(domain: int) -> dict[str, str]:
    """Of a process that speaks DDS, apart from all of other domains."""
    return {
        "PATH": os.environ["PATH"],
        "HOME": os.environ.get("HOME", "/tmp"),
        "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
        "ROS_DOMAIN_ID": str(domain),
        "OMP_NUM_THREADS": "1",
        "MUJOCO_GL": "disable",  # nothing is drawn, and looking for libraries that draw takes a while
    }


def python() -> Path:
    """The interpreter that has rclpy; skips the test where there can be none, and says why."""
    if sys.version_info[:2] != (3, 11):
        pytest.skip("the packages of ROS 2 Jazzy are for Python 3.11")
    found = Path(os.environ.get("DISKNAV_ROS2", FOLDER / "bin" / "python"))
    if not _works(found):
        _install()
        if not _works(found):
            pytest.skip(
                f"no ROS 2: {', '.join(PACKAGES)} cannot be had from the package registry, or do not run"
            )
    return found


def _works(interpreter: Path) -> bool:
    if not interpreter.exists():
        return False
    done = subprocess.run(
        [interpreter, "-c", NEEDED], env=environment(77), capture_output=True, timeout=60, check=False
    )
    return done.returncode == 0


def _install() -> None:
    make = [sys.executable, "-m", "venv", "--without-pip", FOLDER]
    subprocess.run(make, check=False, capture_output=True, timeout=120)
    pip = [sys.executable, "-m", "pip", "--python", FOLDER / "bin" / "python"]
    fill = [*pip, "install", "--quiet", "--no-compile", "--disable-pip-version-check", *PACKAGES]
    subprocess.run(fill, check=False, capture_output=True, timeout=400)
