"""Stand-ins between a node, a bus and what they belong to."""

from typing import Any


class Proxy:
    """Another object, but for the attributes that are given."""

    def __init__(self, of: Any, **instead: Any) -> None:
        self.__dict__.update(instead, of=of)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.of, name)
