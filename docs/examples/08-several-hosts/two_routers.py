"""Two linked routers, as on two hosts, and every process by itself: python two_routers.py [PORT PORT]."""

import subprocess
import sys

NODE = [sys.executable, "-m", "disknav", "node"]
ports = sys.argv[1:3] or ["7447", "7448"]
base, left = (f"tcp/127.0.0.1:{port}" for port in ports)  # on real hosts their addresses


def start(*words: str) -> subprocess.Popen[bytes]:
    """One process of the fleet; with real hosts, each of these lines is given on its own host."""
    return subprocess.Popen([*NODE, *words])


def router(*words: str) -> subprocess.Popen[bytes]:
    """A router that listens already: it prints a line when it does."""
    process = subprocess.Popen([*NODE, "router", *words], stderr=subprocess.PIPE)
    assert process.stderr is not None
    process.stderr.readline()
    return process


routers = [router("--listen", base), router("--listen", left, "--connect", base)]
robots = [start("robot", str(i), "--run", "pair", "--router", base if i < 3 else left) for i in range(1, 7)]
world = start("world", "figure-1", "--run", "pair", "--router", base)
try:
    status = world.wait()  # 0: all robots arrived without contact
finally:
    for process in (*robots, *routers):
        process.terminate()
    for process in (*robots, *routers):
        process.wait(timeout=20.0)
sys.exit(status)
