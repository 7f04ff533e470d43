"""Control laws: the paper's, and others to compare it with. The safety filter comes after any of them."""

from agents.law.api import Law, View
from agents.law.choice import GuardedLaw, choose, require

__all__ = ["GuardedLaw", "Law", "View", "choose", "require"]
