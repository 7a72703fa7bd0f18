"""JSON schemas of the Foxglove messages that fill its 3D panel.

Written after the public description of Foxglove's message schemas: names, fields and
which of them are required are theirs.
"""

from functools import cache
from typing import Any

Schema = dict[str, Any]


def frame_transforms() -> Schema:
    """Return the schema ``foxglove.FrameTransforms``."""
    transform = record(
        "foxglove.FrameTransform",
        timestamp=_time(),
        parent_frame_id=TEXT,
        child_frame_id=TEXT,
        translation=_vector(),
        rotation=_quaternion(),
    )
    return record("foxglove.FrameTransforms", transforms=_list(transform))


def scene_update() -> Schema:
    """Return the schema ``foxglove.SceneUpdate``."""
    deletion = record(
        "foxglove.SceneEntityDeletion",
        timestamp=_time(),
        type={"type": "integer", "oneOf": [{"const": 0}, {"const": 1}]},  # this id, or all
        id=TEXT,
    )
    return record("foxglove.SceneUpdate", deletions=_list(deletion), entities=_list(_entity()))


def record(title: str, **properties: Schema) -> Schema:
    """Return the schema of a map with these keys, all required."""
    required = list(properties)
    return {"title": title, "type": "object", "properties": properties, "required": required}


NUMBER: Schema = {"type": "number"}
COUNT: Schema = {"type": "integer", "minimum": 0}
TEXT: Schema = {"type": "string"}
FLAG: Schema = {"type": "boolean"}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


@cache
def _time() -> Schema:
    nanoseconds = {"type": "integer", "minimum": 0, "maximum": 999_999_999}
    return record("time", sec=COUNT, nsec=nanoseconds)


@cache
def _duration() -> Schema:
    nanoseconds = {"type": "integer", "minimum": 0, "maximum": 999_999_999}
    return record("duration", sec={"type": "integer"}, nsec=nanoseconds)


@cache
def _vector(title: str = "foxglove.Vector3") -> Schema:
    return record(title, x=NUMBER, y=NUMBER, z=NUMBER)


@cache
def _quaternion() -> Schema:
    return record("foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)


@cache
def _color() -> Schema:
    return record("foxglove.Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)


def _primitive(kind: str, **properties: Schema) -> Schema:
    pose = record("foxglove.Pose", position=_vector(), orientation=_quaternion())
    return _list(record(f"foxglove.{kind}Primitive", pose=pose, **properties))


def _entity() -> Schema:
    point, color = _vector("foxglove.Point3"), _color()
    mesh = {"points": _list(point), "color": color, "colors": _list(color), "indices": _list(COUNT)}
    line = {"type": "integer", "oneOf": [{"const": value} for value in (0, 1, 2)]}
    sized = {"size": _vector(), "color": color}
    return record(
        "foxglove.SceneEntity",
        timestamp=_time(),
        frame_id=TEXT,
        id=TEXT,
        lifetime=_duration(),
        frame_locked=FLAG,
        metadata=_list(record("foxglove.KeyValuePair", key=TEXT, value=TEXT)),
        arrows=_primitive(
            "Arrow",
            shaft_length=NUMBER,
            shaft_diameter=NUMBER,
            head_length=NUMBER,
            head_diameter=NUMBER,
            color=color,
        ),
        cubes=_primitive("Cube", **sized),
        spheres=_primitive("Sphere", **sized),
        cylinders=_primitive("Cylinder", bottom_scale=NUMBER, top_scale=NUMBER, **sized),
        lines=_primitive("Line", type=line, thickness=NUMBER, scale_invariant=FLAG, **mesh),
        triangles=_primitive("TriangleList", **mesh),
        texts=_primitive(
            "Text",
            billboard=FLAG,
            font_size=NUMBER,
            scale_invariant=FLAG,
            color=color,
            text=TEXT,
        ),
        models=_primitive(
            "Model",
            scale=_vector(),
            color=color,
            override_color=FLAG,
            url=TEXT,
            media_type=TEXT,
            data={"type": "string", "contentEncoding": "base64"},
        ),
    )
