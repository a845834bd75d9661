"""Arrays in the keys of a recorded sensor, where a file would be named: point clouds, depth images, labels."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .checks import array, length, three
from .labels import Labels
from .poses import Frame

_Files = list[tuple[str, bytes]]

#: The keys of a recording that have arrays, and what belongs to each.
_KINDS = {"cloud": (), "depth": ("intrinsics", "frame"), "labels": ("origin_m", "voxel_size_m")}


def depth_points(depth_m: ArrayLike, intrinsics: Sequence[float], frame: Frame = "link") -> NDArray[np.float64]:
    """The points of a depth image, in the frame of its camera.

    >>> depth_m = np.full((48, 64), 2.0)
    >>> points = pr.depth_points(depth_m, (60, 60, 31.5, 23.5))
    >>> points.shape, points[:, 0].max()

    :param depth_m: float, shape (rows, columns): metres along the optical axis; 0, NaN or infinite where nothing returned.
    :param intrinsics: fx, fy, cx, cy of an image without distortion, in pixels; the middle of the first pixel is at (0, 0).
    :param frame: "link" (x forward, y left, z up) or "optical" (z forward, x right, y down).
    :returns: float64, shape (n, 3), row by row, without pixels that did not return.
    :raises ValueError: for another shape, whole numbers (which may be millimetres), or intrinsics that are wrong.
    """
    return _points("depth_m", depth_m, intrinsics, frame)


def with_recordings(keys: Mapping[str, Any]) -> tuple[Mapping[str, Any], _Files]:
    """The keys of a study that name files instead of the arrays of recorded sensors, and the files."""
    sensors, files = keys.get("sensor"), _Files()
    if not isinstance(sensors, (list, tuple)):
        return keys, files
    told = []
    for number, sensor in enumerate(sensors):
        recordings = sensor.get("recording") if isinstance(sensor, Mapping) else None
        if isinstance(recordings, (list, tuple)):
            place, stem = f"keys.sensor[{number}].recording", f"recordings/sensor {number}"
            entries = [
                _recording(f"{place}[{entry}]", f"{stem} {entry}", recording, files) if isinstance(recording, Mapping) else recording
                for entry, recording in enumerate(recordings)
            ]
            sensor = {**sensor, "recording": entries}
        told.append(sensor)
    return {**keys, "sensor": told}, files


def cloud_file(place: str, cloud: ArrayLike) -> bytes:
    """Points as a file that has each number as it is (Point Cloud Library, version 0.7)."""
    points = array(place, cloud, np.float64)
    if points.ndim not in (2, 3) or points.shape[-1] != 3:
        raise ValueError(f"{place}: has shape {points.shape}, must be (n, 3), or (rows, columns, 3) with NaN where nothing returned")
    points = points.reshape(-1, 3)
    count = len(points)
    header = [
        *("VERSION 0.7", "FIELDS x y z", "SIZE 8 8 8", "TYPE F F F", "COUNT 1 1 1"),
        *(f"WIDTH {count}", "HEIGHT 1", f"POINTS {count}", "DATA binary", ""),
    ]
    return "\n".join(header).encode() + np.ascontiguousarray(points, "<f8").tobytes()


def _recording(place: str, stem: str, recording: Mapping[str, Any], files: _Files) -> dict[str, Any]:
    """A recording that names a file in the place of an array."""
    whole = dict(recording)
    given = [key for key in _KINDS if key in whole]
    if "pose" in whole:
        if any(key in whole for key in ("position_m", "yaw_deg", "quaternion")):
            raise ValueError(f"{place}: has pose, and position_m, yaw_deg or quaternion: give one of them")
        whole |= _pose(f"{place}.pose", whole.pop("pose"))
    if not given:
        return whole
    if len(given) + ("file" in whole) > 1:
        raise ValueError(f"{place}: has {' and '.join([*given, *(['file'] if 'file' in whole else [])])}: give one of them")
    [key] = given
    value, words = whole.pop(key), {word: whole.pop(word) for word in _KINDS[key] if word in whole}
    at = f"{place}.{key}"
    if key == "labels":
        name, data = f"{stem}.npz", _labels_file(at, value, words)
    else:
        if key == "depth":
            if "intrinsics" not in words:
                raise ValueError(f"{place}: has no intrinsics: (fx, fy, cx, cy) in pixels")
            value = _points(at, value, words["intrinsics"], words.get("frame", "link"))
        name, data = f"{stem}.pcd", cloud_file(at, value)
    files.append((name, data))
    return {**whole, "file": name}


def _points(place: str, depth: ArrayLike, intrinsics: Any, frame: Any) -> NDArray[np.float64]:
    image = array(place, depth)
    if image.ndim != 2:
        raise ValueError(f"{place}: has shape {image.shape}, must be (rows, columns)")
    if image.dtype.kind != "f":
        raise ValueError(f"{place}: is of {image.dtype}, must be metres as floats: where it has millimetres, multiply it by 0.001")
    if frame not in ("link", "optical"):
        raise ValueError(f'frame = {frame!r}: must be "link" (x forward, y left, z up) or "optical" (z forward, x right, y down)')
    numbers = array("intrinsics", intrinsics, np.float64)
    if numbers.shape != (4,) or not np.isfinite(numbers).all() or not (numbers[:2] > 0).all():
        raise ValueError(f"intrinsics = {numbers.tolist()}: must be fx, fy, cx, cy in pixels, fx and fy above 0")
    fx, fy, cx, cy = numbers
    z = image.astype(np.float64)
    if (z < 0).any():
        raise ValueError(f"{place}: has depths below 0, must be metres along the optical axis")
    rows, columns = np.nonzero(np.isfinite(z) & (z > 0))
    forward = z[rows, columns]
    right, down = (columns - cx) / fx * forward, (rows - cy) / fy * forward
    return np.column_stack([right, down, forward] if frame == "optical" else [forward, -right, -down])


def _pose(place: str, pose: ArrayLike) -> dict[str, Any]:
    """The keys of a pose: x, y, z and the yaw in degrees, or x, y, z and a quaternion."""
    numbers = array(place, pose, np.float64)
    if numbers.shape not in ((4,), (7,)):
        what = "x, y, z in metres and the yaw in degrees, or x, y, z and a quaternion w, x, y, z"
        raise ValueError(f"{place}: has shape {numbers.shape}, must be {what}")
    position, rest = numbers[:3].tolist(), numbers[3:].tolist()
    if len(rest) == 1:
        return {"position_m": position, "yaw_deg": rest[0]}
    return {"position_m": position, "quaternion": dict(zip("wxyz", rest))}


def _labels_file(place: str, labels: Any, words: Mapping[str, Any]) -> bytes:
    """Labels as an archive of arrays."""
    arrays: dict[str, Any] = {}
    if isinstance(labels, Labels):
        words = {"origin_m": labels.origin_m, "voxel_size_m": labels.voxel_size_m, **words}
        arrays["hits"] = labels.hits
        labels = labels.labels
    if "origin_m" not in words or "voxel_size_m" not in words:
        raise ValueError(f"{place}: needs origin_m, the lowest corner of voxel [0, 0, 0], and voxel_size_m, in metres")
    voxels = array(place, labels)
    if voxels.ndim != 3 or voxels.dtype not in (np.bool_, np.int8, np.uint8):
        raise ValueError(f"{place}: has shape {voxels.shape} of {voxels.dtype}, must be (nx, ny, nz) of int8, uint8 or bool")
    archive = io.BytesIO()
    origin_m: Any = three("origin_m", words["origin_m"])
    size_m = length("voxel_size_m", words["voxel_size_m"])
    np.savez_compressed(archive, labels=voxels.view(np.uint8), origin_m=origin_m, voxel_size_m=size_m, **arrays)
    return archive.getvalue()
