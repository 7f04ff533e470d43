"""Compiles a wheel where there is a C compiler, as `make compile` does in a checkout."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

_SECONDS = 1200  # to compile


class CompiledModules(BuildHookInterface):  # type: ignore[type-arg]  # hatchling's stub wants a configuration that hooks do not use
    """Adds what mypyc makes of the folders that compile.py names; without it the wheel is pure Python."""

    _copy: Path | None = None

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """See hatchling. An editable installation runs the checkout, where `make compile` compiles."""
        if version == "editable":
            return
        self._copy = Path(tempfile.mkdtemp(prefix="disknav-"))
        try:
            twins = self._compile(self._copy)
        except (OSError, subprocess.SubprocessError) as error:
            output = getattr(error, "stderr", None) or getattr(error, "stdout", None) or ""
            self.app.display_warning(
                f"not compiled, so robots take about five times as long: {error}\n{output}"
            )
            return
        build_data["pure_python"] = False
        build_data["infer_tag"] = True
        build_data["force_include"].update({str(self._copy / twin): str(twin) for twin in twins})

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:  # noqa: ARG002
        """See hatchling."""
        if self._copy is not None:
            shutil.rmtree(self._copy)

    def _compile(self, copy: Path) -> list[Path]:
        """Compile in `copy`, where nothing of the checkout is in the way; what was made, relative to it."""
        root = Path(self.root)
        for name in ("disknav", "protocol", "agents", "world", "deploy"):
            shutil.copytree(root / name, copy / name, ignore=shutil.ignore_patterns("*.so", "__pycache__"))
        for name in ("pyproject.toml", "compile.py"):
            shutil.copy(root / name, copy)
        self._run([sys.executable, "compile.py"], copy)
        return sorted(path.relative_to(copy) for path in copy.rglob("*.so") if "build" not in path.parts)

    @staticmethod
    def _run(command: list[str], folder: Path) -> str:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=_SECONDS, check=True
        )
        return done.stdout
