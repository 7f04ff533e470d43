import pytest

from agents.bases import base as choice
from protocol.errors import UsageError


def test_a_base_outside_says_how_to_install_what_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    choice.require()
    monkeypatch.setattr(choice, "find_spec", lambda _: None)
    with pytest.raises(UsageError, match=r'pip install "disknav\[ros2\]"'):
        choice.require()
