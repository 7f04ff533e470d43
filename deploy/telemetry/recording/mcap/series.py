"""The files of one recording as if they were one: a file says which one follows it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from mcap.records import Message

from deploy.telemetry.recording.mcap.contents import Contents, contents
from protocol.errors import RecordingError, UsageError


class Series:
    """As `Contents`, of a file and all that follow it.

    Attributes:
        path: of the first.
        metadata: of the first what the run is, of the last how it ended.
        topics: by channel, of what was read so far; a topic has one number in all files.
        cut: one has no proper end or is damaged, or the next is not there.
    """

    def __init__(self, parts: list[Contents], complete: bool) -> None:
        self.path, self._parts, self._complete = parts[0].path, parts, complete
        self.topics: dict[int, str] = {}
        first, self.metadata = parts[0].metadata, dict(parts[-1].metadata)
        self.metadata.update({name: first[name] for name in ("run", "scenario") if name in first})
        self._numbers: dict[str, int] = {}

    @property
    def cut(self) -> bool:
        """See above."""
        return not self._complete or any(part.cut for part in self._parts)

    def messages(self, progress: Callable[[float], None] | None = None) -> Iterator[Message]:
        """File after file; see `Contents.messages`."""
        for done, part in enumerate(self._parts):

            def tell(share: float, done: int = done) -> None:
                if progress is not None:
                    progress((done + share) / len(self._parts))

            for message in part.messages(tell):
                topic = part.topics[message.channel_id]
                message.channel_id = self._numbers.setdefault(topic, len(self._numbers) + 1)
                self.topics[message.channel_id] = topic
                yield message


def _run(part: Contents) -> str:
    return part.metadata.get("run", {}).get("name", "")


def series(path: Path) -> Contents | Series:
    """Look through a file and those that follow it.

    Raises:
        UsageError, RecordingError: as `contents`, of the first.
    """
    parts, complete = [contents(path)], True
    seen = {path}
    while following := parts[-1].metadata.get("recorder", {}).get("following"):
        path = path.with_name(Path(following).name)
        try:
            part = contents(path)
        except (UsageError, RecordingError):
            complete = False
            break
        if path in seen or _run(part) != _run(parts[0]):
            complete = False  # another recording has taken the name
            break
        seen.add(path)
        parts.append(part)
    return parts[0] if complete and len(parts) == 1 else Series(parts, complete)
