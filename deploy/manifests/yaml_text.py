"""YAML for people: in the order given, with a comment on top."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from protocol.errors import UsageError


def yaml_text(documents: Sequence[Any], head: str) -> str:
    """Several documents as one file."""
    try:
        import yaml
    except ModuleNotFoundError as error:
        raise UsageError("this needs the library PyYAML: pip install 'disknav[engines]'") from error

    class Plain(yaml.SafeDumper):
        """Repeats what occurs twice instead of pointing to it."""

        def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002
            return True

    comment = "".join(f"# {line}\n" for line in head.splitlines())
    return comment + "---\n".join(
        yaml.dump(each, Dumper=Plain, sort_keys=False, width=110, allow_unicode=True) for each in documents
    )
