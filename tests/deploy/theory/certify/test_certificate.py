"""The certificate's file, stopping and going on, and what a second opinion says of it."""

import base64
import math
import zlib
from pathlib import Path

import msgspec
import pytest

from deploy.library.load import read
from deploy.theory.certify.certificate import Certificate, GoalSet, ProofError, Slab, fetch, path_for, store
from deploy.theory.certify.prove import prove
from deploy.theory.certify.replay import replay
from protocol.errors import UsageError

pytestmark = pytest.mark.slow

PAIR = GoalSet(((0.05, 0.0), (-0.045, 0.01)), (0.04, 0.05), 0.3)
TRIPLE = GoalSet.of(read("figure-2"))


def proven(goals: GoalSet, k: float) -> Certificate:
    certificate = Certificate(goals=goals, scenario="test")
    list(prove(certificate, k))
    return certificate


@pytest.fixture(scope="module")
def pair() -> Certificate:
    return proven(PAIR, 100.0)


@pytest.mark.parametrize(("goals", "k"), [(PAIR, 100.0), (TRIPLE, 10_000.0)])
def test_what_is_stored_has_a_second_opinion(goals: GoalSet, k: float, tmp_path: Path) -> None:
    certificate = proven(goals, k)
    store(certificate, tmp_path / "kept.json")
    back = fetch(tmp_path / "kept.json", goals)
    assert back == certificate
    checked = replay(back, 3.0)
    assert checked.verified == certificate.proven == k
    assert checked.enough(None)
    assert checked.enough(1.5 * k)
    assert not checked.enough(0.5 * k)
    assert checked.boxes <= 2 * certificate.boxes


def test_it_stops_after_any_slab_and_goes_on() -> None:
    certificate = Certificate(goals=TRIPLE, scenario="test")
    next(found for found in prove(certificate, 100.0) if found.proven)
    assert certificate.proven == 1000.0
    list(prove(certificate, 300.0))
    assert certificate.proven == 300.0
    assert not list(prove(certificate, 500.0)), "known already"
    assert certificate.proven == 300.0


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"workspace": 0.3', '"workspace": 0.31', "damaged"),
        ('"k": 1000.0', '"k": 999.0', "damaged"),
        ('"format": "disknav certificate 2"', '"format": "disknav certificate 1"', "format"),
        ('"radii"', '"radiuses"', "is not a certificate"),
        ("{", "", "is not a certificate"),
    ],
)
def test_a_damaged_file_is_refused(old: str, new: str, says: str, pair: Certificate, tmp_path: Path) -> None:
    path = tmp_path / "pair.json"
    store(pair, path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ProofError, match=says):
        fetch(path)


def test_files_that_are_missing_or_of_other_goals_are_refused(pair: Certificate, tmp_path: Path) -> None:
    with pytest.raises(ProofError, match="cannot be read"):
        fetch(tmp_path / "nowhere.json")
    store(pair, tmp_path / "pair.json")
    with pytest.raises(ProofError, match=r"pair.json.*\n.*the scenario's goals"):
        fetch(tmp_path / "pair.json", TRIPLE)
    with pytest.raises(UsageError, match="cannot write a certificate"):
        store(pair, tmp_path / "pair.json" / "in a file")


def test_forged_claims_do_not_survive_a_second_opinion(pair: Certificate) -> None:
    """A branching that stops below the k at which minima appear, ends too early, or goes on too long."""
    empty = Slab(2.2, 1, 0.0, "eJz7DwABAAEA")  # one node: nothing there
    assert empty.nodes == b"\xff"
    checked = replay(Certificate(goals=TRIPLE, slabs=[empty]), 3.0)
    assert (checked.verified, checked.enough(None)) == (None, False)
    assert "not verified" in str(checked.failed)
    first, slab, *others = pair.slabs
    for nodes in (slab.nodes[:-1], slab.nodes + b"\xff"):
        damaged = [first, _slab(slab.k, nodes), *others]
        checked = replay(msgspec.structs.replace(pair, slabs=damaged), 3.0)
        assert (checked.verified, checked.enough(None)) == (1000.0, False)
        assert "damaged" in str(checked.failed)


def test_a_branching_that_never_ends_is_not_followed_nor_unpacked(pair: Certificate) -> None:
    assert len(_slab(1000.0, bytes(1_000_000), boxes=1).nodes) == 2
    checked = replay(msgspec.structs.replace(pair, slabs=[_slab(1.0, bytes(3000))]), 3.0)
    assert "too deep" in str(checked.failed)
    assert checked.boxes < 1500


def test_the_clock_is_looked_at_between_boxes(pair: Certificate) -> None:
    """Of a small slab too, and of seven robots, whose boxes take longest."""
    assert all(slab.boxes < 100 for slab in pair.slabs)
    checked = replay(pair, 0.0)
    assert (checked.verified, checked.boxes) == (None, 1)
    assert "time is up" in str(checked.failed)
    goals = tuple((0.1 * n, 0.0) for n in range(-3, 4))
    found = next(prove(Certificate(goals=GoalSet(goals, (0.01,) * 7, 1.0)), 1000.0))
    assert found.trial
    assert found.trial.boxes < 1000


def _slab(k: float, nodes: bytes, boxes: int | None = None) -> Slab:
    text = base64.b64encode(zlib.compress(nodes)).decode()
    return Slab(k, len(nodes) if boxes is None else boxes, 0.0, text)


BLOCKED = [GoalSet(((0.0, 0.0), (0.08, 0.0)), (0.04, 0.04), 0.3), GoalSet(PAIR.goals, PAIR.radii, 0.05)]


@pytest.mark.parametrize(
    ("forged", "says"),
    [
        *(({"goals": goals}, "touch, overlap") for goals in BLOCKED),
        ({"goals": GoalSet(PAIR.goals * 4, PAIR.radii * 4, 0.3)}, "is not a certificate"),
        ({"goals": GoalSet(PAIR.goals, (0.04, -0.05), 0.3)}, "is not a certificate"),
        ({"goals": GoalSet(PAIR.goals, PAIR.radii, 1e300)}, "is not a certificate"),
        ({"slabs": [Slab(1000.0, 1 << 40, 0.0, "eJz7DwABAAEA")]}, "is not a certificate"),
        ({"slabs": [Slab(1000.0, 2, 0.0, "eJz7DwABAAEA")]}, "another number of nodes"),
        ({"slabs": [Slab(1000.0, 1, 0.0, "eJz7")]}, "is not a certificate"),
        ({"slabs": [Slab(1000.0, 1, 0.0, "!")]}, "is not a certificate"),
    ],
)
def test_a_forged_file_is_refused(
    forged: dict[str, object], says: str, pair: Certificate, tmp_path: Path
) -> None:
    store(msgspec.structs.replace(pair, **forged), tmp_path / "forged.json")
    with pytest.raises(ProofError, match=says):
        fetch(tmp_path / "forged.json")


def test_parts_are_obstacles_and_have_no_certificate() -> None:
    with pytest.raises(UsageError, match="parts"):
        GoalSet.of(read("parts-4"))


@pytest.mark.parametrize(
    ("goals", "k"), [(BLOCKED[0], 10.0), (PAIR, math.inf), (PAIR, math.nan), (PAIR, 0.0)]
)
def test_what_cannot_have_a_certificate_is_refused(goals: GoalSet, k: float) -> None:
    with pytest.raises(UsageError, match="touch" if k == 10.0 else "positive"):
        next(prove(Certificate(goals=goals), k))


def test_numbers_that_overflow_verify_nothing() -> None:
    one = Slab(5e-324, 1, 0.0, "eJz7DwABAAEA")
    assert replay(Certificate(goals=PAIR, slabs=[one]), 0.1).verified is None


def test_a_certificate_lies_beside_its_scenario(tmp_path: Path) -> None:
    (tmp_path / "here.toml").write_text("")
    assert path_for(str(tmp_path / "here.toml")) == tmp_path / "here.certificate.json"
    assert path_for("figure-2") == Path("figure-2.certificate.json")
