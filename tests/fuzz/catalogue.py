"""What is fuzzed: everything that reads what strangers wrote, with valid inputs to begin from.

Beyond raising nothing undeclared, what a reader accepts must survive being written and read again.
"""

from __future__ import annotations

from tests.fuzz.targets.hosts import HOSTS
from tests.fuzz.targets.joining import JOINING
from tests.fuzz.targets.kept import KEPT
from tests.fuzz.targets.keys import KEYS
from tests.fuzz.targets.messages import MESSAGES
from tests.fuzz.targets.orders import ORDERS
from tests.fuzz.targets.participants import PARTICIPANTS
from tests.fuzz.targets.scenarios import SCENARIOS

TARGETS = {**MESSAGES, **JOINING, **PARTICIPANTS, **KEYS, **SCENARIOS, **ORDERS, **HOSTS, **KEPT}
