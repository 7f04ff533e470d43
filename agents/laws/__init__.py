"""Control laws: the paper's, and others to compare it with. The safety filter comes after any of them."""

from agents.laws.choice import GuardedLaw, choose, require
from agents.laws.law import Law
from agents.laws.view import View

__all__ = ["GuardedLaw", "Law", "View", "choose", "require"]
