"""Certificates and their JSON files: goals, and the branching that proves each range of k.

`slabs` go from large k downwards: the first covers every k from its own on, each other one those from its own
up to the one before. `branching` is base64 of zlib of one byte per node in preorder: 255 the box contains no
minimum, 254 one direction descends all over it, otherwise the row that was halved. `digest` detects damage,
not forgery: `deploy.theory.certify.replay` verifies the proof.
"""

from __future__ import annotations

import base64
import hashlib
import math
import os
import zlib
from pathlib import Path
from typing import Annotated, NamedTuple

import msgspec
import numpy as np

from deploy.output import writing
from deploy.theory.function import FleetProblem, obstacle_functions
from protocol.errors import DocumentError, UsageError
from protocol.errors import Problem as Fault
from protocol.scenario.body import Length
from protocol.scenario.model import Position, Scenario

EMPTY, FALLS = 255, 254  # leaves of the branching; other bytes are halved rows
FORMAT = "disknav certificate 2"
SUFFIX = ".certificate.json"
MOST_ROBOTS = 7  # each box is examined for every set of robots
DEEPEST = 500  # boxes that wait at a time
MOST_BOXES = 1 << 28  # of a slab; a small file may hold far more, and they are kept in memory
BLOCKED = "goals that touch, overlap or are not inside the workspace have no certificate"


class ProofError(DocumentError):
    """A certificate is damaged, belongs to other goals, or does not prove what it claims."""


class GoalSet(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The certified goals, radii and workspace, by robot id, m."""

    goals: Annotated[tuple[Position, ...], msgspec.Meta(max_length=MOST_ROBOTS)]
    radii: tuple[Length, ...]
    workspace: Length

    @classmethod
    def of(cls, scenario: Scenario) -> GoalSet:
        """The goals of a scenario.
        Raises UsageError if it has obstacles or parts, or its workspace is a polygon.
        """
        if scenario.shapes:
            raise UsageError("no certificates for scenarios with obstacles or parts: remove them")
        specs = [scenario.spec(robot) for robot in scenario.ids]
        goals = tuple((float(spec.goal[0]), float(spec.goal[1])) for spec in specs)
        return cls(goals, tuple(float(spec.radius) for spec in specs), float(scenario.workspace.disk_radius))

    @property
    def problem(self) -> FleetProblem:
        """The problem for `deploy.theory`, with an arbitrary k."""
        return FleetProblem(np.array(self.goals), np.array(self.radii), self.workspace, 1.0)

    @property
    def is_free(self) -> bool:
        """Whether all robots can be at their goals at once, apart from each other and the boundary."""
        return bool((obstacle_functions(self.problem, np.array(self.goals)) > 0.0).all())


class Slab(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Proof for every k from `k` to the previous slab. boxes: nodes of the branching; seconds: CPU time."""

    k: float
    boxes: Annotated[int, msgspec.Meta(ge=1, le=MOST_BOXES)]
    seconds: float
    branching: str

    @property
    def nodes(self) -> bytes:
        """One byte per node; one more than `boxes` if there are more."""
        packed = base64.b64decode(self.branching, validate=True)
        return zlib.decompressobj().decompress(packed, self.boxes + 1)


class Trial(NamedTuple):
    """The slab that is being searched: its k, the share done, and the number of boxes."""

    k: float
    done: float
    boxes: int


class Certificate(msgspec.Struct, kw_only=True, forbid_unknown_fields=True):
    """Everything proven so far for one set of goals: the content of the file; and the slab being searched."""

    format: str = FORMAT
    scenario: str = ""
    goals: GoalSet
    slabs: list[Slab] = []
    digest: str = ""  # in the file only
    trial: Trial | msgspec.UnsetType = msgspec.UNSET  # not in the file

    @property
    def proven(self) -> float | None:
        """The smallest K for which the goal is proven the only minimum for every k >= K, if any."""
        return self.slabs[-1].k if self.slabs else None

    def proves(self, k: float | None) -> bool:
        """Whether it covers every k from this one on; None: whether it proves anything."""
        return self.proven is not None and (k is None or self.proven <= k)

    @property
    def boxes(self) -> int:
        """Number of nodes of all finished slabs."""
        return sum(slab.boxes for slab in self.slabs)

    @property
    def time(self) -> float:
        """CPU seconds of the finished slabs."""
        return sum(slab.seconds for slab in self.slabs)

    def add(self, k: float, branching: bytes, seconds: float) -> None:
        """Add the next proven slab, down to k."""
        self.trial = msgspec.UNSET
        packed = base64.b64encode(zlib.compress(branching, 9)).decode()
        self.slabs.append(Slab(k, len(branching), round(seconds, 3), packed))

    def kappa(self, k: float) -> tuple[float, float]:
        """Range of 1/k from the previous slab down to k, rounded outward."""
        before = 0.0 if self.proven is None else math.nextafter(1.0 / self.proven, 0.0)
        return before, math.nextafter(1.0 / k, math.inf)


def path_for(scenario: str) -> Path:
    """Path of the certificate: beside a scenario file, or in the working directory for a library name."""
    path = Path(scenario)
    return path.with_name(path.stem + SUFFIX) if path.is_file() else Path(scenario + SUFFIX)


def stored(name: str, scenario: Scenario) -> Certificate | None:
    """The certificate of the scenario `name`, if there is one.
    Raises ProofError if it is damaged, or belongs to other goals.
    """
    path = path_for(name)
    return fetch(path, GoalSet.of(scenario)) if path.exists() else None


def store(certificate: Certificate, path: Path) -> None:
    """Write the file atomically. Raises UsageError if that fails."""
    plain = msgspec.structs.replace(certificate, trial=msgspec.UNSET, digest=_digest(certificate))
    scratch = path.with_name(f".{path.name}.{os.getpid()}")
    with writing(scratch, "write a certificate"):
        scratch.write_bytes(msgspec.json.format(msgspec.json.encode(plain), indent=1) + b"\n")
        scratch.replace(path)


def fetch(path: Path, goals: GoalSet | None = None) -> Certificate:
    """Read a certificate, which must belong to `goals` if given.
    Raises ProofError if it cannot be read, is damaged, or belongs to other goals.
    """
    try:
        certificate = msgspec.json.decode(path.read_bytes(), type=Certificate)
        if certificate.format != FORMAT:
            raise _refused(path, "format", f"is {certificate.format!r}, not {FORMAT!r}")
        if certificate.digest != _digest(certificate):
            raise _refused(path, "digest", "does not fit the contents: the file is damaged")
        certificate.digest = ""
        _check(certificate)
    except OSError as error:
        raise _refused(path, "", f"cannot be read: {error.strerror}") from error
    except (msgspec.MsgspecError, ValueError, zlib.error) as error:
        raise _refused(path, "", f"is not a certificate: {error}") from error
    if goals is not None and certificate.goals != goals:
        raise _refused(path, "goals", "differ from the scenario's goals, radii or workspace")
    return certificate


def _refused(path: Path, where: str, text: str) -> ProofError:
    return ProofError(str(path), [Fault(where, text)])


def _digest(certificate: Certificate) -> str:
    plain = msgspec.structs.replace(certificate, trial=msgspec.UNSET, digest="")
    return hashlib.sha256(msgspec.json.encode(plain)).hexdigest()


def _check(certificate: Certificate) -> None:
    goals, ks = certificate.goals, [slab.k for slab in certificate.slabs]
    if any(not 0.0 < after < before for before, after in zip([math.inf, *ks], ks, strict=False)):
        raise ValueError("k does not decrease from slab to slab")
    if not goals.goals or len(goals.goals) != len(goals.radii):
        raise ValueError("the numbers of goals and radii differ")
    if not goals.is_free:
        raise ValueError(BLOCKED)
    if any(slab.boxes != len(slab.nodes) for slab in certificate.slabs):
        raise ValueError("a branching has another number of nodes than it states")
