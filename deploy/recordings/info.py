"""What a recording holds, in numbers."""

from typing import Any

from bus.recording import Port, Recording


def describe(recording: Recording) -> dict[str, Any]:
    """Return a recording's duration [s], ports, losses, attachments and metadata."""
    metadata = recording.metadata
    seconds = (recording.end - recording.start) * 1e-9
    ports = [_port(port, seconds, metadata) for port in recording.ports.values()]
    return {
        "file": str(recording.path),
        "bytes": recording.path.stat().st_size,
        "start_ns": recording.start,
        "duration_s": seconds,
        "messages": sum(port["messages"] for port in ports),
        "lost": sum(port["lost"] for port in ports),
        "ports": ports,
        "attachments": [
            {"name": name, "bytes": len(data)} for name, data in recording.attachments.items()
        ],
        "metadata": {k: v for k, v in metadata.items() if not k.startswith("losses/")},
    }


def _port(port: Port, seconds: float, metadata: dict[str, dict[str, str]]) -> dict[str, Any]:
    losses = metadata.get(f"losses{port.name}", {})
    return {
        "name": port.name,
        "type": port.type,
        "direction": port.direction,
        "messages": port.count,
        "hz": port.count / seconds if seconds > 0 else 0.0,
        "nominal_hz": port.nominal_hz,
        **{key: int(losses.get(key, 0)) for key in ("lost", "refused", "repeated", "sources")},
    }
