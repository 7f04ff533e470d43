"""The `disknav` command as a process: signals, error messages and exit statuses."""

from __future__ import annotations

import os
import sys
from errno import EDQUOT, EFBIG, ENOSPC
from io import TextIOWrapper
from signal import SIGPIPE
from typing import Any, Final

from protocol.process.signals import STOP, Stopped

_UNREAD: Final = 128 + SIGPIPE  # exit status if the reader of standard output has closed it
_FULL: Final = ENOSPC, EDQUOT, EFBIG
_FAULT: Final = 3  # as in deploy/output.py, which is imported later


def main() -> None:
    """Entry point of the `disknav` command. A signal that asks it to end decides its exit status."""
    _open_standard_files()
    STOP.listen()  # before the slow imports
    try:
        status = _run()
    except Stopped:
        STOP.exit()
    except Exception:  # noqa: BLE001  a fault of this software
        sys.excepthook(*sys.exc_info())
        status = _FAULT
    STOP.ignore()
    status = _flushed(status)
    sys.exit(STOP.status or status)


def _open_standard_files() -> None:
    """Open the null device for each standard file that the caller closed, as by `>&-`, also for processes
    started here; otherwise the next socket or file gets its number, and what is meant for the terminal."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # takes the lowest free number
            setattr(sys, name, open(number, "w" if number else "r", closefd=False))  # noqa: SIM115


def _run() -> int:
    from deploy.output import EXIT_INVALID
    from deploy.software import check_compiled
    from protocol.errors import CertificateError, DisknavError, DocumentError, StartError, UsageError
    from protocol.process.installation import explained, is_checkout
    from protocol.process.log import LAUNCHER, LOG, begin

    invalid = DocumentError, UsageError, CertificateError
    begin(LAUNCHER)
    if isinstance(sys.stdout, TextIOWrapper):  # if unbuffered, Python drops what a disk has no room for
        form: Any = {"encoding": sys.stdout.encoding, "errors": "backslashreplace"}
        sys.stdout = open(sys.stdout.fileno(), "w", **form, closefd=False)  # noqa: SIM115
    try:
        if is_checkout():  # files that pip installed have the times of the installation
            check_compiled()
        from deploy.cli.application import app

        app()
    except StartError:  # is logged already
        return _FAULT
    except DisknavError as error:
        LOG.error(error)
        return EXIT_INVALID if isinstance(error, invalid) else _FAULT
    except ModuleNotFoundError as error:
        if (explanation := explained(error)) is None:
            raise
        LOG.error(explanation)
        return EXIT_INVALID
    except OSError as error:
        if error.errno not in _FULL:
            raise
        LOG.error(f"cannot write to {error.filename or 'standard output'}: {error.strerror}")
        return _FAULT
    except SystemExit as ending:
        unread = isinstance(ending.__context__, BrokenPipeError)  # so typer and rich end
        return _UNREAD if unread else ending.code if isinstance(ending.code, int) else _FAULT
    return 0


def _flushed(status: int) -> int:
    """Write the rest of standard output; returns the exit status, another one if that fails."""
    try:
        sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # Python writes the rest once more as it ends
        if isinstance(error, BrokenPipeError):
            return _UNREAD
        if status != _FAULT:  # otherwise the reason is reported already
            from protocol.process.log import LOG

            LOG.error(f"cannot write to standard output: {error.strerror}")
        return _FAULT
    return status
