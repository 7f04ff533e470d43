"""Packages of other owners under disknav's names are noticed, named, and do not run."""

import shutil
import subprocess
import sys
from base64 import urlsafe_b64encode
from hashlib import sha256
from pathlib import Path

import pytest

from disknav import ownership
from tests.scripts import ROOT, ended


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """An environment's folder with a wheel of disknav in it: its Python interface and four packages."""
    home = tmp_path / "site"
    shutil.copytree(ROOT / "disknav", home / "disknav", ignore=shutil.ignore_patterns("__pycache__"))
    for package in ownership.PACKAGES:
        (home / package).mkdir()
        shutil.copy(ROOT / package / "__init__.py", home / package)
    _record(home, "disknav", [f"{package}/__init__.py" for package in ownership.PACKAGES])
    return home


def _record(home: Path, name: str, files: list[str]) -> None:
    metadata = home / f"{name}-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    rows = []
    for file in files:
        content = (home / file).read_bytes()
        digest = urlsafe_b64encode(sha256(content).digest()).decode().rstrip("=")
        rows.append(f"{file},sha256={digest},{len(content)}\n")
    (metadata / "RECORD").write_text("".join(rows))


def _python(path: list[Path], code: str) -> subprocess.CompletedProcess[str]:
    """Run `code` in a Python that knows nothing but `path` and the standard library."""
    code = f"import sys; sys.path[:0] = {[str(each) for each in path]!r}; {code}"
    call = [sys.executable, "-I", "-S", "-c", code]
    return subprocess.run(call, capture_output=True, text=True, timeout=60, check=False)


def _import(path: list[Path]) -> subprocess.CompletedProcess[str]:
    return _python(path, "from disknav import ownership; ownership.check()")


def test_a_file_of_the_users_is_found_first(site: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "world.py").write_text("raise SystemExit('a stranger ran')\n")
    said = _import([mine, site]).stderr
    assert "ForeignPackageError" in said
    assert str(mine / "world.py") in said
    assert "rename it" in said
    assert "a stranger ran" not in said


def test_another_distribution_has_overwritten_a_package(site: Path) -> None:
    (site / "agents" / "__init__.py").write_text("raise SystemExit('a stranger ran')\n")
    _record(site, "many-agents", ["agents/__init__.py"])
    said = _import([site]).stderr
    assert "`agents` of disknav" in said
    assert "overwritten by many-agents" in said
    assert "environment of its own" in said


def test_another_distribution_took_a_package_along_when_it_went(site: Path) -> None:
    (site / "agents" / "__init__.py").unlink()
    said = _import([site]).stderr
    assert "`agents` of disknav is missing" in said
    assert "--force-reinstall" in said


def test_the_command_says_so_too(site: Path) -> None:
    (site / "protocol" / "__init__.py").write_text("raise SystemExit('a stranger ran')\n")
    done = _python([site], "from disknav.__main__ import main; main()")
    assert done.returncode == 3
    assert done.stderr.startswith("disknav: `protocol` of disknav")
    assert "Traceback" not in done.stderr


def test_importing_disknav_imports_nothing_else() -> None:
    code = "import sys, disknav; print(sorted({'numpy', 'zenoh', 'deploy', 'typer'} & set(sys.modules)))"
    assert ended(code).stdout.strip() == "[]"


def test_an_unknown_name_says_what_there_is() -> None:
    import disknav

    with pytest.raises(AttributeError, match=r"no attribute 'lode'; it has .*load"):
        disknav.lode  # noqa: B018
    assert all(getattr(disknav, name) is not None for name in disknav.__all__)
