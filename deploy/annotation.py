"""Types of fields as ports tell them, in Python's notation: read, never executed."""

import ast
from typing import Any, Literal, Optional, Union

LONGEST = 1000  # characters
_NAMES = {
    **{kind.__name__: kind for kind in (bool, int, float, str, bytes, list, tuple, dict)},
    **{"None": None, "NoneType": None, "Any": Any},
}


def read_annotation(text: str) -> Any:
    """Return the type of an annotation such as ``list[str] | None``; Any when it says nothing."""
    try:
        return _read(ast.parse(text[:LONGEST], mode="eval").body)
    except (SyntaxError, ValueError, LookupError, TypeError, RecursionError):
        return Any


def _read(node: ast.AST) -> Any:
    match node:
        case ast.Constant(None):
            return None
        case ast.Name(name) | ast.Attribute(ast.Name("typing"), name):
            return _NAMES[name]
        case ast.BinOp(left, ast.BitOr(), right):
            return Union[_read(left), _read(right)]  # noqa: UP007  # None | None is no type
        case ast.Subscript(ast.Name(name) | ast.Attribute(ast.Name("typing"), name), inside):
            return _subscript(name, inside.elts if isinstance(inside, ast.Tuple) else [inside])
    raise ValueError("not the notation of a type")


def _subscript(name: str, inside: list[ast.expr]) -> Any:
    if name == "Literal":
        return Literal[tuple(ast.literal_eval(item) for item in inside)]
    if name == "dict":
        return dict[str, _read(inside[1])]
    if name in ("list", "tuple"):
        return list[_read(inside[0])]
    if name == "Optional":
        return Optional[_read(inside[0])]  # noqa: UP045
    if name == "Union":
        return Union[tuple(_read(item) for item in inside)]  # noqa: UP007
    raise ValueError(f"no type {name}")
