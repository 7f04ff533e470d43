"""A fleet that cannot start says so once, and ends; it is not started again and again."""

import socket
import sys
from collections.abc import Iterator

import pytest

from tests.scripts import ended

pytestmark = [pytest.mark.process, pytest.mark.timeout(120)]


@pytest.fixture
def taken() -> Iterator[str]:
    """An endpoint on whose port something else listens."""
    with socket.create_server(("127.0.0.1", 0)) as other:
        yield f"tcp/127.0.0.1:{other.getsockname()[1]}"


def _served(*options: str) -> tuple[int, list[str]]:
    program = f"import sys; sys.argv[0] = {sys.argv[0]!r}; from disknav.__main__ import main; main()"
    process = ended(program, "run", "swap-2", "--keep", "--quiet", *options, timeout=60.0)
    return process.returncode, process.stderr.splitlines()


def test_a_port_that_is_taken_is_one_line_that_says_what_to_do(taken: str) -> None:
    status, (line,) = _served("--run", "start-taken", "--listen", taken)
    assert status == 3
    assert "taken by" in line
    assert "give another endpoint" in line


def test_and_robots_that_cannot_start() -> None:
    """Their law is refused by each of their processes, not by the launcher."""
    status, lines = _served("--run", "start-law", "--set", "control.law=nowhere:Law")
    assert status in (2, 3)
    assert 1 <= len(lines) <= 4
