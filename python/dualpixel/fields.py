"""JSON files whose fields are checked as they are taken: errors name file, field, value and what is allowed."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator
from typing import Any, NoReturn, Optional

from .errors import InputError
from .pictures import Path

_LONGEST = 60  # characters of a value in a message


def _no_number(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number of JSON")


def parse_json(text: str, where: str) -> Any:
    """A JSON document; InputError with one line where it is none."""
    try:
        return json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where}: is not valid JSON: {error}") from error


def read_json(path: Path) -> Any:
    """The same of a file."""
    try:
        with open(path, encoding="utf-8") as file:
            return parse_json(file.read(), os.fspath(path))
    except OSError as error:
        raise InputError(f"{os.fspath(path)}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{os.fspath(path)}: is not valid JSON: must be UTF-8") from error


def _shown(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= _LONGEST else text[:_LONGEST] + "..."


def _is_finite(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


class Fields:
    """An object of the file `file` at the JSON pointer `where`. Each method takes one field and returns its value, or
    `default` where it is absent; a field without a default is required. Raises InputError."""

    def __init__(self, document: Any, file: str, where: str = ""):
        self.file, self.where = file, where
        if not isinstance(document, dict):
            raise InputError(f"{file}: {where + ': ' if where else ''}must be an object")
        self.document: dict[str, Any] = document

    def fail(self, name: str, message: str) -> NoReturn:
        raise InputError(f"{self.file}: {self.where}/{name}: {message}")

    def refuse(self, name: str, allowed: str) -> NoReturn:
        self.fail(name, f"{_shown(self.document[name])}: must be {allowed}")

    def _is_absent(self, name: str, default: Any) -> bool:
        if name in self.document:
            return False
        if default is ...:
            self.fail(name, "is required")
        return True

    def number(self, name: str, low: float, high: float, default: Any = ...) -> Any:
        """Where `high` is infinite, the text "inf" is infinity, which JSON cannot say otherwise."""
        if self._is_absent(name, default):
            return default
        value = self.document[name]
        if value == "inf" and math.isinf(high):
            return math.inf
        if not (_is_finite(value) and low <= value <= high):
            self.refuse(name, f"a number in [{low:g}, {high:g}]")
        return value

    def integer(self, name: str, low: int, high: int, default: Any = ...) -> Any:
        if self._is_absent(name, default):
            return default
        value = self.document[name]
        if not (isinstance(value, int) and not isinstance(value, bool) and low <= value <= high):
            self.refuse(name, f"an integer in [{low}, {high}]")
        return value

    def numbers(self, name: str, count: int, default: Any = ...) -> Any:
        if self._is_absent(name, default):
            return default
        value = self.document[name]
        if not (isinstance(value, list) and len(value) == count and all(map(_is_finite, value))):
            self.refuse(name, f"{count} finite numbers")
        return value

    def text(self, name: str, default: Any = ...) -> Any:
        if self._is_absent(name, default):
            return default
        value = self.document[name]
        if not isinstance(value, str):
            self.refuse(name, "a string")
        return value

    def choice(self, name: str, *allowed: str) -> str:
        value = self.text(name)
        if value not in allowed:
            self.refuse(name, f"one of {', '.join(map(repr, allowed))}")
        return value

    def path(self, name: str, default: Any = ...) -> Any:
        """Of a file inside the folder."""
        value = self.text(name, default)
        if value is not default and not _lies_inside(value):
            self.refuse(name, "a path inside the folder")
        return value

    def paths(self, name: str) -> list[str]:
        """None of them where the field is absent."""
        value = self.document.get(name, [])
        if not (isinstance(value, list) and all(isinstance(entry, str) and _lies_inside(entry) for entry in value)):
            self.refuse(name, "an array of paths inside the folder")
        return value

    def object(self, name: str, default: Any = ...) -> Fields:
        value = default if self._is_absent(name, default) else self.document[name]
        return Fields(value, self.file, f"{self.where}/{name}")

    def objects(self, name: str, most: Optional[int] = None) -> Iterator[Fields]:
        """At least one."""
        self._is_absent(name, ...)
        value = self.document[name]
        if not isinstance(value, list) or not value or (most is not None and len(value) > most):
            self.fail(name, f"must be an array of {'objects' if most is None else f'1 to {most} objects'}")
        return (Fields(entry, self.file, f"{self.where}/{name}/{i}") for i, entry in enumerate(value))


def _lies_inside(path: str) -> bool:
    return bool(path) and path.isprintable() and not os.path.isabs(path) and ".." not in path.split("/")
