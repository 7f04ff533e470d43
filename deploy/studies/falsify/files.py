"""Scenario files of what was found, with a header that says what they show."""

from __future__ import annotations

from pathlib import Path

from deploy.studies.falsify.campaign import Finding
from deploy.studies.falsify.runs.violation import MEANING
from protocol.errors import UsageError

UNSHRUNK = 100  # files of violations that are not shrunk; more would say nothing new


class Files:
    """A folder that is made when there is something to keep."""

    def __init__(self, folder: Path) -> None:
        """Raises UsageError: `folder` is something else."""
        if folder.exists() and not folder.is_dir():
            raise UsageError(f"{folder} is not a folder; say with --out where to keep what is found")
        self._folder = folder
        self._written: set[Path] = set()

    def path(self, finding: Finding) -> Path:
        """Where a finding is kept."""
        return self._folder / f"{finding.violation.kind}-{finding.seed}-{finding.number}.toml"

    def keep(self, finding: Finding) -> None:
        """Write a finding, over what it was before it was shrunk."""
        path = self.path(finding)
        if not finding.tried and path not in self._written and len(self._written) >= UNSHRUNK:
            return
        self._written.add(path)
        self._folder.mkdir(parents=True, exist_ok=True)
        path.write_text(header(finding) + finding.scenario, encoding="utf-8")


def header(finding: Finding) -> str:
    """Comments at the head of a file."""
    violation = finding.violation
    size = f"the smallest of {finding.tried} that were tried" if finding.tried else "as it was drawn"
    text = [f"{MEANING[violation.kind]}: {violation.text}", size]
    return "".join(f"# {line}\n" for part in text for line in part.splitlines()) + "\n"
