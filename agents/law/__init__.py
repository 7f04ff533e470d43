"""Control laws: the paper's, with additions, reciprocal velocities, and external laws."""

from agents.law.api import Law, View
from agents.law.choice import GuardedLaw, choose

__all__ = ["GuardedLaw", "Law", "View", "choose"]
