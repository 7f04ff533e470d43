"""What a freshly forked process does before and after its real work."""

from __future__ import annotations

import ctypes
import importlib
import os
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection as Channel
from pathlib import Path
from typing import NoReturn

from deploy.processes.fork_messages import Start
from protocol.errors import DisknavError
from protocol.process.log import LOG, set_process_title
from protocol.process.signals import Stopped

FAULT = 3  # exit status of a process that an exception ended
_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>
_LIBC = ctypes.CDLL(None)


def run_forked(
    start: Start, run: str, report: int | None, lifeline: int, begin_log: Callable[[str], None]
) -> NoReturn:
    """Call what `start` names in this process, which exists for nothing else, and exit.

    Its title is its name and `run`. `report` is the writing end of a pipe for text to the supervisor,
    `lifeline` the reading end of one that ends with the fork server; `begin_log` begins its log, by its
    name. The exit status is what the function returns, 0 if a signal ended it, 3 after an exception: one of
    this software's own says its message, any other logs its traceback. The fork server listens to `STOP`, and
    so does this process from the beginning.
    """
    code = FAULT
    try:
        set_process_title(start.name.replace("-", " ", 1), run)
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        _close_all_but({report, lifeline})
        _end_with_parent(lifeline)
        os.dup2(2, 1)  # standard output is the command's alone
        begin_log(start.name)
        LOG.info(f"process {os.getpid()} begins")
        start.scheduling.apply()  # before there are other threads
        module, _, function = start.entry.partition(":")
        arguments = start.arguments
        if report is not None:
            arguments = (*arguments, Channel(report, readable=False).send)
        code = getattr(importlib.import_module(module), function)(*arguments)
    except Stopped:
        code = 0
    except SystemExit as ending:
        code = ending.code if isinstance(ending.code, int) else FAULT
    except DisknavError as error:
        LOG.error(error)
    except BaseException:  # noqa: BLE001  nothing above this frame could report it
        LOG.exception("failed:")
    finally:
        try:
            LOG.info("ends with status %s", code)
            sys.stderr.flush()
            sys.stdout.flush()
        finally:  # whoever read them may be gone
            # Never back into the fork server's loop, and past threads that would linger.
            os._exit(code if isinstance(code, int) else FAULT)


def end_with_pipe(lifeline: int) -> None:
    """Kill this process, from a thread, when the other end of a pipe is gone: portable, but needs to run."""

    def watch() -> None:
        os.read(lifeline, 1)
        os.kill(os.getpid(), signal.SIGKILL)

    threading.Thread(target=watch, name="lifeline", daemon=True).start()


def _end_with_parent(lifeline: int) -> None:
    if sys.platform == "linux":
        # By the kernel: needs no thread, and reaches a stopped process too.
        if _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL) != 0:
            raise OSError("prctl(PR_SET_PDEATHSIG) failed")
        if os.getppid() == 1 or _ended(lifeline):  # the parent died before that
            os._exit(FAULT)
    else:
        end_with_pipe(lifeline)


def _ended(pipe: int) -> bool:
    os.set_blocking(pipe, False)
    try:
        return os.read(pipe, 1) == b""
    except BlockingIOError:
        return False


def _close_all_but(kept: set[int | None]) -> None:
    """Close what was inherited besides the standard streams: a held pipe would never end for others."""
    for descriptor in [int(each.name) for each in Path("/dev/fd").iterdir()]:
        if descriptor > 2 and descriptor not in kept:
            with suppress(OSError):  # the one that listed them is closed already
                os.close(descriptor)
