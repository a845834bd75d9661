"""Checks of arguments before they reach the compiled half: what is wrong is a ``ValueError`` that names the argument."""

from __future__ import annotations

import importlib
import json
import os
from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray


def needed(module: str, extra: str) -> Any:
    """A module that comes with an extra of the package."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        text = f"this needs {module}, which is not installed: pip install 'perirobot[{extra}]' or pip install {module}"
        raise ModuleNotFoundError(text, name=module) from None


def array(name: str, values: ArrayLike, dtype: DTypeLike | None = None) -> NDArray[Any]:
    """Values as an array."""
    try:
        return np.asarray(values, dtype)
    except (ValueError, TypeError):
        raise ValueError(f"{name}: must be an array of numbers, with rows of one length") from None


def three(name: str, numbers: ArrayLike | None) -> list[float] | None:
    """A point, if there is one."""
    if numbers is None:
        return None
    point = array(name, numbers, np.float64)
    if point.shape != (3,):
        raise ValueError(f"{name} = {point.tolist()}: must be x, y, z in metres")
    return [float(number) for number in point]


def length(name: str, metres: Any) -> float:
    """A length in metres."""
    try:
        value = float(metres)
    except (TypeError, ValueError):
        value = float("nan")
    if not 0 < value < float("inf"):
        raise ValueError(f"{name} = {metres!r}: must be a length above 0, in metres")
    return value


def index(name: str, number: Any) -> int:
    """A number that counts from 0."""
    if not isinstance(number, (int, np.integer)) or number < 0:
        raise ValueError(f"{name} = {number!r}: must be a whole number, counted from 0")
    return int(number)


def texts(name: str, words: Any) -> list[str]:
    """Several names, or one."""
    if isinstance(words, str):
        return [words]
    try:
        return [str(word) for word in words]
    except TypeError:
        raise ValueError(f"{name} = {words!r}: must be a name or a list of names") from None


def json_of(place: str, keys: Any) -> str:
    """Keys of a file as JSON."""
    return json.dumps(_plain(place, keys))


def _plain(place: str, value: Any) -> Any:
    """Keys of a file as JSON has them: arrays of numpy are lists, paths are text."""
    if isinstance(value, Mapping):
        wrong = [key for key in value if not isinstance(key, str)]
        if wrong:
            raise ValueError(f"{place}: {wrong[0]!r} must be text, as every key")
        return {key: _plain(f"{place}.{key}", entry) for key, entry in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return _plain(place, value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(f"{place}[{number}]", entry) for number, entry in enumerate(value)]
    if isinstance(value, PathLike):
        return os.fspath(value)
    if value is None:
        raise ValueError(f"{place} = None: leave the key out instead")
    if isinstance(value, float) and not np.isfinite(value):
        raise ValueError(f"{place} = {value}: must be a finite number")
    if isinstance(value, (bool, int, float, str)):
        return value
    raise ValueError(f"{place}: {value!r} must be a number, text, list or dict")
