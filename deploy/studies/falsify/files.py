"""Scenario files of what was found, with a header that says what they show."""

from __future__ import annotations

from pathlib import Path

from deploy.studies.falsify.campaign import Finding
from deploy.studies.falsify.runs.violation import MEANING
from protocol.errors import UsageError

_TWO = "deploy.studies.falsify.runs.observe.observe(second, before=[first])"
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
        """Where the scenario of a finding is kept."""
        which = "" if finding.first is None else "-second"
        return self._folder / f"{finding.violation.kind}-{finding.seed}-{finding.number}{which}.toml"

    def keep(self, finding: Finding) -> None:
        """Write a finding, over what it was before it was shrunk."""
        path = self.path(finding)
        if not finding.tried and path not in self._written and len(self._written) >= UNSHRUNK:
            return
        self._written.add(path)
        self._folder.mkdir(parents=True, exist_ok=True)
        text = header(finding)
        if finding.first is not None:
            before = path.with_name(f"{path.stem.removesuffix('-second')}-first.toml")
            before.write_text(f"# goes before {path.name}\n\n{finding.first}", encoding="utf-8")
            text = f"# after {before.name} on the same robots: {_TWO}\n" + text
        path.write_text(text + finding.scenario, encoding="utf-8")


def header(finding: Finding) -> str:
    """Comments at the head of a file."""
    violation = finding.violation
    size = f"the smallest of {finding.tried} that were tried" if finding.tried else "as it was drawn"
    text = [f"{MEANING[violation.kind]}: {violation.text}", size]
    return "".join(f"# {line}\n" for part in text for line in part.splitlines()) + "\n"
