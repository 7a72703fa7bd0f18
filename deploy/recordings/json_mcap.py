"""A recording as an MCAP file of JSON messages, which PlotJuggler and Foxglove read."""

import heapq
import json
from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import count
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from bus.recording import Recording
from deploy.recordings.foxglove_schemas import frame_transforms, scene_update
from deploy.recordings.keyed import Keyed, schema_of
from deploy.recordings.labels import Labels
from deploy.recordings.scene import TOPICS, Scene
from deploy.recordings.selection import Item, Selection
from robot_model import Robot

WINDOW = 200_000_000  # ns by which a message may have arrived out of order
SCHEMAS = {"foxglove.FrameTransforms": frame_transforms, "foxglove.SceneUpdate": scene_update}


class Times:
    """When a message is plotted: at its measurement, in wall time or the session's clock [ns].

    The recorder sees messages in bundles; plotted at their arrival they would be stairs.
    """

    def __init__(self, session: bool):
        self._session = session

    def of(self, item: Item) -> int:
        """Return the time of one message."""
        if self._session:
            return max(item.envelope.stamp, 0)
        return item.envelope.acquired or item.envelope.sent or item.arrival


class JsonWriter:
    """An MCAP file with JSON messages; must be finished, or nobody opens it."""

    def __init__(self, path: Path):
        self.counts: Counter[str] = Counter()
        self._file = path.open("wb")
        self._writer = Writer(self._file, compression=CompressionType.ZSTD)
        self._writer.start(profile="", library="wrenchbus")
        self._channels: dict[str, int] = {}
        self._schemas: dict[tuple[str, bytes], int] = {}

    def keep(self, recording: Recording) -> None:
        """Copy the attachments and metadata of a recording."""
        for name, data in recording.attachments.items():
            self._writer.add_attachment(0, 0, name, "application/octet-stream", data)
        for name, texts in recording.metadata.items():
            self._writer.add_metadata(name, texts)

    def has(self, topic: str) -> bool:
        """Whether the topic was opened."""
        return topic in self._channels

    def open(self, topic: str, schema_name: str, schema: bytes) -> None:
        """Add a topic."""
        key = schema_name, schema
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(schema_name, "jsonschema", schema)
        id_ = self._schemas[key]
        self._channels[topic] = self._writer.register_channel(topic, "json", id_)

    def write(self, topic: str, time: int, value: dict[str, Any], sequence: int = 0) -> None:
        """Add a message at ``time`` [ns]."""
        data = json.dumps(value, allow_nan=False, separators=(",", ":")).encode()
        channel = self._channels[topic]
        self._writer.add_message(channel, time, data, time, sequence & 0xFFFFFFFF)
        self.counts[topic] += 1

    def finish(self) -> None:
        """Write the index and close."""
        self._writer.finish()
        self._file.close()


def convert(
    recording: Recording,
    selection: Selection,
    robots: Mapping[str, Robot],
    out: Path,
    rate: float | None = None,
    session_time: bool = False,
) -> dict[str, int]:
    """Write the messages of a selection, and scenes of its robots; return messages per topic.

    Args:
        recording: Where attachments and metadata are copied from.
        selection: What is converted.
        robots: Robots by model hash.
        out: The file; one that exists is written over.
        rate: Messages per second and port at most [Hz]; all of them when None.
        session_time: Plot over the session's (simulated) clock, not wall time.
    """
    writer = JsonWriter(out)
    try:
        writer.keep(recording)
        scenes = [Scene(robot) for robot in robots.values()]
        labels = Labels(robots)
        keyed = {port.name: Keyed(port, labels) for port in selection.ports}
        thinner = _Thinner(rate)
        for time, item in _in_order(selection.items(), Times(session_time)):
            for scene in scenes:
                _draw(writer, scene, item, time)
            if thinner.takes(item.port.name, time):
                _write(writer, keyed[item.port.name], item, time)
    finally:
        writer.finish()
    return dict(writer.counts)


def _write(writer: JsonWriter, keyed: Keyed, item: Item, time: int) -> None:
    value = keyed.map_of(item.message, item.envelope)
    if not writer.has(item.port.name):
        writer.open(item.port.name, item.port.type, schema_of(item.port, value))
    writer.write(item.port.name, time, value, item.envelope.seq)


def _draw(writer: JsonWriter, scene: Scene, item: Item, time: int) -> None:
    for topic, when, message in scene.updates(item, time):
        if not writer.has(topic):
            for name, schema in TOPICS.items():
                text = json.dumps(SCHEMAS[schema]()).encode()
                writer.open(scene.topic(name), schema, text)
        writer.write(topic, when, message)


class _Thinner:
    """Lets the first message of each period through, per port."""

    def __init__(self, rate: float | None):
        self._period = 0 if rate is None else round(1e9 / rate)
        self._last: dict[str, int] = {}

    def takes(self, port: str, time: int) -> bool:
        if not self._period:
            return True
        number = time // self._period
        taken = self._last.get(port) != number
        self._last[port] = number
        return taken


def _in_order(items: Iterator[Item], times: Times) -> Iterator[tuple[int, Item]]:
    """Yield by time of plotting what came by arrival."""
    heap: list[tuple[int, int, Item]] = []
    order = count()
    for item in items:
        heapq.heappush(heap, (times.of(item), next(order), item))
        while heap[0][2].arrival < item.arrival - WINDOW:
            time, _, oldest = heapq.heappop(heap)
            yield time, oldest
    while heap:
        time, _, oldest = heapq.heappop(heap)
        yield time, oldest
