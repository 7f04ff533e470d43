"""The `disknav` command as a process: signals, and how errors become words and exit statuses."""

from __future__ import annotations

import signal
import sys
from io import TextIOWrapper

from deploy.output.exit_status import EXIT_FAULT, EXIT_INTERRUPTED, EXIT_INVALID
from deploy.software import compiled
from protocol.bus.drive import uninterrupted
from protocol.errors import CertificateError, DisknavError, DocumentError, KeyGrammarError, UsageError
from protocol.process.installation import explained, is_checkout
from protocol.process.log import LAUNCHER, LOG, begin
from protocol.process.signals import ENDING

_INVALID = (DocumentError, UsageError, KeyGrammarError, CertificateError)


def main() -> None:
    """Entry point of the `disknav` command. SIGTERM and a closed terminal end it as Ctrl-C does."""
    begin(LAUNCHER)
    if isinstance(sys.stdout, TextIOWrapper):  # characters that the terminal's encoding lacks are escaped
        sys.stdout.reconfigure(errors="backslashreplace")
    for number in (signal.SIGINT, signal.SIGTERM):  # a shell's script has its `command &` ignore the first
        signal.signal(number, signal.default_int_handler)
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:  # as `nohup` asks
        signal.signal(signal.SIGHUP, signal.default_int_handler)
    try:
        with uninterrupted():  # modules that Cython made swallow an interruption of their import
            if is_checkout():  # what pip unpacks has the times of unpacking
                compiled.check()
            from deploy.commands.application import app
        app()
    except ModuleNotFoundError as error:
        if (said := explained(error)) is None:
            raise
        _fail(said)
    except DisknavError as error:
        _fail(error)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)
    finally:
        for number in ENDING:  # it ends anyway, with the status that it has
            signal.signal(number, signal.SIG_IGN)


def _fail(error: DisknavError) -> None:
    LOG.error(error)
    sys.exit(EXIT_INVALID if isinstance(error, _INVALID) else EXIT_FAULT)


if __name__ == "__main__":
    main()
