"""What all tests share: how hypothesis searches."""

import os

from hypothesis import HealthCheck, settings

# A busy machine is no counterexample; in continuous integration the same examples are tried every time.
settings.register_profile("disknav", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("disknav"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "disknav")
