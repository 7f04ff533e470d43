"""A Ctrl-C that comes where Python drops it still stops a study."""

import signal
from collections.abc import Iterator, Sequence

import pytest

from deploy.studies.harness.runners import runner
from deploy.studies.harness.runners.ctrl_c import heeded
from deploy.studies.harness.runners.run_log import RunLog
from deploy.studies.harness.runners.worker import Batch, Outcome, execute, outcomes
from tests.deploy.studies.harness.runners.test_runner import _study


class Dropping:
    """Workers during whose second result a Ctrl-C comes, and is dropped as in a finalizer."""

    def __init__(self, _jobs: int) -> None:
        pass

    def __enter__(self) -> "Dropping":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def run(self, batches: Sequence[Batch]) -> Iterator[Outcome]:
        for number, job in enumerate(job for batch in batches for job in batch):
            if number == 1:
                with pytest.raises(KeyboardInterrupt):
                    signal.raise_signal(signal.SIGINT)
            yield from outcomes([job], execute)


def test_nothing_is_lost_and_the_usual_handler_is_there_afterwards() -> None:
    before = signal.getsignal(signal.SIGINT)
    with heeded() as heed:
        heed()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            heed()
    assert signal.getsignal(signal.SIGINT) is before


def test_a_study_stops(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "WorkerPool", Dropping)
    outcome = runner.execute(_study(3), "local", RunLog(None), jobs=1)
    assert not outcome.complete
    assert outcome.executed == 2
