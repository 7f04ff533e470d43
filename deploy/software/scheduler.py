"""The scheduler of a Dask cluster, reached from here."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from protocol.errors import ProcessError, UsageError
from protocol.installation import missing_library

if TYPE_CHECKING:
    from distributed import Client

_REACHING = 10.0  # s for the scheduler to answer


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
