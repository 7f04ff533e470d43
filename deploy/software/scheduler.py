"""The scheduler of a Dask cluster, reached from here."""

from __future__ import annotations

import logging
from collections.abc import Collection
from concurrent.futures import CancelledError
from typing import TYPE_CHECKING, TypeVar

from protocol.errors import DisknavError, ProcessError, UsageError
from protocol.process.installation import missing_library

if TYPE_CHECKING:
    from distributed import Client, Future

_T = TypeVar("_T")
_REACHING = 10.0  # s for the scheduler to answer
_LOOK = 1.0  # s between looks at whether there still are workers
_DESERTED = 60.0  # s without any worker


def connected(address: str) -> Client:
    """A client of the scheduler at `address`, such as `tcp://10.0.0.1:8786`.

    Raises:
        UsageError: the library is missing, or `address` is none.
        ProcessError: no scheduler answers there.
    """
    try:
        from distributed import Client
    except ModuleNotFoundError as error:
        raise missing_library("a cluster", "distributed", "cluster") from error
    for name in [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]:
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what matters is said by exceptions
    try:
        return Client(address, timeout=_REACHING, set_as_default=False)
    except ValueError as error:
        raise UsageError(f"{address!r} is no address of a Dask scheduler: {error}") from error
    except OSError as error:
        raise ProcessError(
            f"no Dask scheduler answers at {address} within {_REACHING:g} s; "
            "is it running (`dask scheduler`), and reachable from here?"
        ) from error


def finished(client: Client, futures: Collection[Future[_T]]) -> list[Future[_T]]:
    """Those that are done, as soon as there is one.

    Raises:
        ProcessError: the scheduler is gone, or all workers are.
    """
    from distributed import TimeoutError as NoneYet
    from distributed import wait

    deserted = 0.0
    while futures and deserted < _DESERTED:
        try:
            with client.as_current():
                return list(wait(list(futures), timeout=_LOOK, return_when="FIRST_COMPLETED").done)
        except NoneYet:
            deserted = 0.0 if client.nthreads() else deserted + _LOOK
        except CancelledError:
            raise lost(client, "is gone, or cancelled what was given to it") from None
    if futures:
        raise lost(client, f"has had no worker for {_DESERTED:g} s")
    return []


def result(client: Client, future: Future[_T]) -> _T:
    """What a task gave.

    Raises:
        ProcessError: its workers were lost, it failed, or the scheduler is gone.
        DisknavError: what the task itself raised.
    """
    from distributed import KilledWorker

    try:
        value: _T = future.result()
    except DisknavError:
        raise
    except CancelledError:
        raise lost(client, "is gone, or cancelled what was given to it") from None
    except KilledWorker as error:
        raise lost(client, f"lost every worker that was given {future.key}: {error}") from error
    except Exception as error:
        raise lost(client, f"has a worker that could not do its part: {error!r}") from error
    return value


def lost(client: Client, why: str) -> ProcessError:
    """What to tell of a cluster that cannot go on."""
    address = client.scheduler.address if client.scheduler is not None else "?"
    return ProcessError(f"the scheduler at {address} {why}; the same command goes on from what is done")
