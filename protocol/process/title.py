"""What `ps` and `top` call a process, so that the one that is meant can be found among its like."""

from __future__ import annotations

from setproctitle import setproctitle, setthreadtitle

_SHORT = 15  # bytes that Linux keeps of a process's short name


def entitle(role: str, run: str = "") -> None:
    """Have `ps -f` show this process as `disknav robot 3 (run yard)`; to be called on its main thread.

    The short name, in `top`, is `robot 3 yard`: it begins with the role, lest a robot's number be cut off.
    """
    setproctitle(f"disknav {role} (run {run})" if run else f"disknav {role}")
    setthreadtitle(f"{role} {run}".rstrip()[:_SHORT])
