"""Arrays in the keys of a scene, where a file would name a table: joints of people, joints of robots over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .checks import array

#: The keys of an object that name tables of a person's joints.
_PEOPLE = ("mannequin", "keypoints")

#: The keys of snapshots that list the joints of a robot.
_ROBOTS = ("joints_deg", "joints_m")

_Files = list[tuple[str, bytes]]


def with_tables(name: str, scene: Mapping[str, Any]) -> tuple[Mapping[str, Any], _Files]:
    """A scene that names tables in the place of its arrays, and the tables, which are text."""
    objects = scene.get("object")
    if not isinstance(objects, (list, tuple)):
        return scene, []
    files = _Files()
    told = [
        _object(f"scenes[{name!r}].object[{number}]", f"{name}/object {number}", entry, files)
        for number, entry in enumerate(objects)
    ]
    return {**scene, "object": told}, files


def _object(place: str, stem: str, entry: Any, files: _Files) -> Any:
    if not isinstance(entry, Mapping):
        return entry
    whole = dict(entry)
    snapshots = whole.get("snapshots", {})
    snapshots = dict(snapshots) if isinstance(snapshots, Mapping) else snapshots
    for key in _PEOPLE:
        if _is_array(whole.get(key)):
            joints = array(f"{place}.{key}", whole[key], np.float64)
            if joints.ndim == 3 and isinstance(snapshots, dict):
                snapshots.setdefault(key, joints)
                joints = joints[0] if len(joints) else joints
            whole[key] = _table(f"{place}.{key}", f"{stem} {key}.csv", joints, files)
        given = snapshots.get(key) if isinstance(snapshots, dict) else None
        if given is not None and (_is_array(given) or (isinstance(given, (list, tuple)) and any(map(_is_array, given)))):
            snapshots[key] = [
                _table(f"{place}.snapshots.{key}[{number}]", f"{stem} {key} {number}.csv", joints, files)
                if _is_array(joints)
                else joints
                for number, joints in enumerate(given)
            ]
    if isinstance(snapshots, dict):
        for key in _ROBOTS:
            if isinstance(snapshots.get(key), Mapping):
                snapshots[key] = _moments(f"{place}.snapshots.{key}", snapshots[key])
        animation = snapshots.get("animation")
        if isinstance(animation, Mapping) and isinstance(animation.get("joints"), Mapping):
            at, file = f"{place}.snapshots.animation.joints", f"{stem} joints.csv"
            snapshots["animation"] = {**animation, "joints": _motion(at, file, animation["joints"], files)}
        if snapshots:
            whole["snapshots"] = snapshots
    return whole


def _is_array(value: Any) -> bool:
    return hasattr(value, "__array__")


def _table(place: str, file: str, joints: Any, files: _Files) -> str:
    """Writes the joints of a person; NaN is an unknown joint."""
    points = array(place, joints, np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"{place}: has shape {points.shape}, must be (joints, 3), or (moments, joints, 3) for several moments")
    if np.isinf(points).any():
        raise ValueError(f"{place}: must be finite, or NaN where a joint is unknown")
    rows = [",".join("" if np.isnan(number) else repr(float(number)) for number in row) for row in points]
    files.append((file, "\n".join(["x_m,y_m,z_m", *rows, ""]).encode()))
    return file


def _columns(place: str, columns: Mapping[str, Any]) -> dict[str, NDArray[np.float64]]:
    """Arrays of one length by the names of joints."""
    told = {str(name): array(f"{place}[{name!r}]", values, np.float64) for name, values in columns.items()}
    shapes = sorted({values.shape for values in told.values()})
    if len(shapes) != 1 or len(shapes[0]) != 1 or shapes[0] == (0,):
        raise ValueError(f"{place}: has arrays of shapes {shapes}, must have one of shape (moments,) for each joint")
    return told


def _moments(place: str, columns: Mapping[str, Any]) -> list[dict[str, float]]:
    """The joints of each moment."""
    told = _columns(place, columns)
    count = len(next(iter(told.values())))
    return [{name: float(values[moment]) for name, values in told.items()} for moment in range(count)]


def _motion(place: str, file: str, columns: Mapping[str, Any], files: _Files) -> str:
    """Writes joints over time."""
    told = _columns(place, columns)
    if "time_s" not in told:
        raise ValueError(f"{place}: has no time_s, the seconds of each row")
    names = ["time_s", *(name for name in told if name != "time_s")]
    rows = [",".join(repr(float(number)) for number in row) for row in zip(*(told[name] for name in names))]
    files.append((file, "\n".join([",".join(names), *rows, ""]).encode()))
    return file
