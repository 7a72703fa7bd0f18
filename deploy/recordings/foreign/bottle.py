"""YARP's Bottle in its text form.

Values are separated by blanks or commas: integers (also ``0x1f``), floats (``nan``, ``inf``),
texts with or without quotes, lists in parentheses, blobs in braces, and vocabs in brackets
(``[ok]``; ``true``, ``false`` and ``null`` without). In a quoted text a backslash escapes.
"""

import re
from typing import Any

NESTED = re.compile(r'["\\(){}\[\]]')
NUMBER = re.compile(r"[+-]?(0[xX][0-9a-fA-F]{1,8}|\d{1,18})")
ESCAPES = {"n": "\n", "r": "\r", "0": "\0"}
BLANKS = " \t\r\n,"
CLOSING = {"(": ")", "{": "}"}
DEPTH = 64


class BottleError(ValueError):
    """A text is no Bottle."""


def parse(text: str) -> list[Any]:
    """Return the values of a Bottle: int, float, str, bool, None, bytes and lists of them.

    A vocab becomes its text. Raises BottleError when parentheses or quotes do not match.
    """
    if NESTED.search(text) is None:
        return [_word(word) for word in text.replace(",", " ").split()]
    reader = _Reader(text)
    values = reader.values("")
    return values


class _Reader:
    def __init__(self, text: str):
        self._text = text
        self._at = 0
        self._depth = 0

    def values(self, closing: str) -> list[Any]:
        """Read up to a closing character, or to the end of the text."""
        found: list[Any] = []
        while self._at < len(self._text):
            character = self._text[self._at]
            if character in BLANKS:
                self._at += 1
            elif character == closing:
                self._at += 1
                return found
            else:
                found.append(self._value(character))
        if closing:
            raise BottleError(f"'{closing}' is missing")
        return found

    def _value(self, character: str) -> Any:
        if character in CLOSING:
            return self._nested(character)
        if character == '"':
            return self._quoted()
        if character == "[":
            return self._vocab()
        if character in ")}]":
            raise BottleError(f"'{character}' without its opening")
        start = self._at
        while self._at < len(self._text) and self._text[self._at] not in BLANKS + "(){}":
            self._at += 1
        return _word(self._text[start : self._at])

    def _nested(self, opening: str) -> Any:
        self._depth += 1
        if self._depth > DEPTH:
            raise BottleError(f"more than {DEPTH} lists inside each other")
        self._at += 1
        inside = self.values(CLOSING[opening])
        self._depth -= 1
        if opening == "(":
            return inside
        if not all(type(value) is int and 0 <= value < 256 for value in inside):
            raise BottleError("a blob holds something else than bytes")
        return bytes(inside)

    def _quoted(self) -> str:
        self._at += 1
        characters = []
        while self._at < len(self._text):
            character = self._text[self._at]
            self._at += 1
            if character == '"':
                return "".join(characters)
            if character == "\\" and self._at < len(self._text):
                escaped = self._text[self._at]
                self._at += 1
                character = ESCAPES.get(escaped, escaped)
            characters.append(character)
        raise BottleError("a quote is not closed")

    def _vocab(self) -> str:
        end = self._text.find("]", self._at)
        if end < 0:
            raise BottleError("']' is missing")
        word = self._text[self._at + 1 : end]
        self._at = end + 1
        return word


WORDS: dict[str, Any] = {"true": True, "false": False, "null": None}


def _word(word: str) -> Any:
    if word in WORDS:
        return WORDS[word]
    if word[0] in "+-.0123456789in":
        if NUMBER.fullmatch(word):
            return int(word, 16) if "x" in word.lower() else int(word)
        try:
            return float(word) if "_" not in word else word
        except ValueError:
            pass
    return word
