"""The smallest scenario that still shows the same: whatever can be left out or said more simply, is."""

from __future__ import annotations

import copy
from collections.abc import Callable, Collection

from deploy.library.load import resolved
from deploy.studies.falsify.shrinking.simpler import PASSES, Pass, forget
from protocol.errors import ScenarioError
from protocol.scenario.file import document_of, parse_document
from protocol.scenario.model import Scenario
from protocol.scenario.shape import Document

Shows = Callable[[Scenario], bool]


def shrunk(scenario: Scenario, shows: Shows, budget: int) -> tuple[Scenario, int]:
    """The scenario after every simplification that it survives, and how many were tried.

    Args:
        scenario: what shows something.
        shows: whether another scenario (k a number) shows the same.
        budget: how many may be tried at most.
    """
    search = Search(shows, budget)
    document, before = document_of(scenario), None
    while document != before and not search.spent:
        before = document
        for simpler in PASSES:
            document = search.exhaust(document, simpler)
    return parse_document(document), search.tried


def among(ids: Collection[int], scenario: Scenario) -> Scenario | None:
    """The scenario without robots of other ids; None if it does not hold without them."""
    document = document_of(scenario)
    for robot in scenario.ids:
        if robot not in ids:
            forget(robot, document)
    try:
        return resolved(parse_document(document, scenario.name))
    except ScenarioError:
        return None


class Search:
    """Tries simpler documents, up to a number of them."""

    def __init__(self, shows: Shows, budget: int) -> None:
        self.tried = 0
        self._shows, self._budget = shows, budget

    @property
    def spent(self) -> bool:
        """Whether no more may be tried."""
        return self.tried >= self._budget

    def exhaust(self, document: Document, simpler: Pass) -> Document:
        """One pass: every edit that it offers, and after one that is kept those that it offers then."""
        edits, place = simpler(document), 0
        while place < len(edits) and not self.spent:
            candidate = copy.deepcopy(document)
            edits[place](candidate)
            if candidate != document and self._still(candidate):
                document = candidate
                edits = simpler(document)  # the next edit has moved to this place
            else:
                place += 1
        return document

    def _still(self, document: Document) -> bool:
        try:
            scenario = resolved(parse_document(document))
        except ScenarioError:
            return False
        self.tried += 1
        return self._shows(scenario)
