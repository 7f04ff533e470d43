"""Start a fleet that stays up, give it orders, and stop it: python orders.py [ENDPOINT]."""

import signal
import subprocess
import sys

import disknav

endpoint = sys.argv[1] if len(sys.argv) > 1 else "tcp/127.0.0.1:7447"
command = ["run", "swap-6", "--keep", "--run", "yard", "--quiet", "--record", "yard.mcap", "--listen"]
fleet = subprocess.Popen([sys.executable, "-m", "disknav", *command, endpoint])
try:
    with disknav.operate("yard", router=endpoint, within=30.0) as orders:
        pillar = orders.place((0.0, 0.0), radius=0.02)  # an obstacle in the middle
        orders.stands(pillar, within=60.0)
        number = orders.send(3, (0.15, -0.05), (0.15, 0.05), within=60.0)  # two goals, one after the other
        print(orders.outcome(3, number))
        orders.take(pillar)
finally:
    fleet.send_signal(signal.SIGINT)  # as Ctrl-C: the result is complete
    fleet.wait(timeout=30.0)
