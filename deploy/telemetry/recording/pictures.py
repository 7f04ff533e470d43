"""The scene of a run within its recording: topics beside those of the run, for Foxglove and ROS tools."""

from __future__ import annotations

from collections.abc import Iterable

from deploy.telemetry.recording.mcap.file import McapFile
from deploy.telemetry.scene.fleet import DRAWN, TOPICS, FleetScene, Picture
from protocol.messages import Message
from protocol.scenario.model import Scenario


class Pictures:
    """Draws what is recorded into the same file, at most ten times a simulated second.

    Raises:
        OSError: (all methods) the file cannot be written.
    """

    def __init__(self, file: McapFile, scenario: Scenario) -> None:
        self._file, self._scene = file, FleetScene(scenario)
        self._channels: dict[str, int] = {}
        schemas: dict[str, int] = {}
        for name, topic in TOPICS.items():
            if topic.schema not in schemas:
                schemas[topic.schema] = file.schema(topic.schema, topic.definition, topic.schema_encoding)
            self._channels[name] = file.channel(name, schemas[topic.schema], {}, topic.encoding)
        self._put(self._scene.whole())

    def hear(self, messages: Iterable[Message]) -> None:
        """Draw what has changed by messages that are recorded."""
        for message in messages:
            if type(message) in DRAWN:
                self._put(self._scene.hear(message))

    def _put(self, pictures: Iterable[Picture]) -> None:
        for picture in pictures:
            self._file.message(self._channels[picture.topic], picture.time, picture.data)
