"""Poses as rows of numbers, matrices, or a table with named columns."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import warned
from .checks import array

#: Which axes a rotation turns: x forward, y left, z up, or z forward, x right, y down.
Frame = Literal["link", "optical"]

#: The columns of a pose, as in ``poses.csv`` and ``refined.csv``.
_COLUMNS = ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]

_SHAPES = "must be (n, 7), (n, 4, 4), one such pose, or (n, k, 7) or (n, k, 4, 4) for k equal sensors"


def look_at(position_m: ArrayLike, target_m: ArrayLike) -> NDArray[np.float64]:
    """Poses from which sensors look at points, upright: as :meth:`Study.evaluate` takes them.

    >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
    >>> study.evaluate(pr.look_at([[0, -1.9, 2.2], [1, -1.9, 2.2]], [0, 0, 1]), "camera")

    :param position_m: where the sensors are: x, y, z in metres, shape (..., 3).
    :param target_m: the points, of such a shape; one point may be that of all.
    :returns: float, shape (..., 7): x, y, z and the quaternion w, x, y, z of the frame "link". A sensor that looks straight
        up or down has its left along y.
    :raises ValueError: if a sensor is at its target.
    """
    at, to = array("position_m", position_m, np.float64), array("target_m", target_m, np.float64)
    for name, points in (("position_m", at), ("target_m", to)):
        if points.shape[-1:] != (3,) or not np.isfinite(points).all():
            raise ValueError(f"{name}: has shape {points.shape}, must be (..., 3): x, y, z in metres, finite")
    try:
        at, to = np.broadcast_arrays(at, to)
    except ValueError:
        raise ValueError(f"target_m: has shape {to.shape}, which does not go with {at.shape} of position_m") from None
    x, y, z = np.moveaxis(to - at, -1, 0)
    if ((x == 0) & (y == 0) & (z == 0)).any():
        raise ValueError("target_m: is where the sensor is, so it looks nowhere")
    # 0.0 and -0.0 are the same direction.
    return facing(at, np.arctan2(y + 0.0, x + 0.0), np.arctan2(-z, np.hypot(x, y)))


def facing(at: NDArray[np.float64], yaw: NDArray[np.float64], down: NDArray[np.float64]) -> NDArray[np.float64]:
    """Poses at points, turned from x towards y and then downwards, in radians."""
    yaw, down = yaw / 2, down / 2
    w, x = np.cos(yaw) * np.cos(down), -np.sin(yaw) * np.sin(down)
    y, z = np.cos(yaw) * np.sin(down), np.sin(yaw) * np.cos(down)
    return np.concatenate([at, np.stack([w, x, y, z], axis=-1)], axis=-1)


def each(poses: Any, sensor: str, frame: Frame) -> list[NDArray[np.float64]]:
    """The poses of a sensor, or of each of several equal ones: arrays with 7 or 16 numbers a row."""
    if frame not in ("link", "optical"):
        raise ValueError(f'frame = {frame!r}: must be "link" (x forward, y left, z up) or "optical" (z forward, x right, y down)')
    rows = _table(poses, sensor) if hasattr(poses, "columns") else array("poses", poses, np.float64)
    if rows.shape == (0,):
        rows = rows.reshape(0, 7)
    width = 2 if rows.shape[-2:] == (4, 4) else 1
    if (width == 1 and rows.shape[-1:] != (7,)) or not width <= rows.ndim <= width + 2:
        raise ValueError(f"poses: has shape {rows.shape}, {_SHAPES}: x, y, z in metres and a quaternion w, x, y, z, or a matrix")
    lead = rows.shape[:-width]
    count, copies = (lead[0] if lead else 1), (lead[1] if len(lead) == 2 else 1)
    if copies == 0:
        raise ValueError(f"poses: has shape {rows.shape}, with no sensor in it")
    flat = rows.reshape(count, copies, 7 if width == 1 else 16)
    if width == 1:
        _check_order(flat.reshape(-1, 7)[:, 3:], frame)
    return [np.ascontiguousarray(flat[:, copy]) for copy in range(copies)]


def _table(table: Any, sensor: str) -> NDArray[np.float64]:
    """The poses in a table of pandas or polars, whatever the order of its columns."""
    names = [str(name) for name in table.columns]
    missing = [name for name in _COLUMNS if name not in names]
    if missing:
        raise ValueError(f"poses: has no column {missing[0]!r}: needs {', '.join(_COLUMNS)}, as in poses.csv, and has {names}")
    others = {str(name) for name in table["sensor"]} - {sensor} if "sensor" in names else set()
    if others:
        raise ValueError(f"poses: has rows of sensor {min(others)!r}: keep those of {sensor!r} only")
    return np.column_stack([array(f"poses[{name!r}]", table[name], np.float64) for name in _COLUMNS])


def _check_order(quaternions: NDArray[np.float64], frame: Frame) -> None:
    """Warns if sensors are upright only if the quaternions are read in the other usual order."""

    def upright(w: Any, x: Any, y: Any, z: Any) -> tuple[Any, Any]:
        """How far the sensor's left and its up point upwards."""
        right_or_x, left_or_y, up_or_z = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
        return (left_or_y, up_or_z) if frame == "link" else (-right_or_x, -left_or_y)

    first, second, third, fourth = quaternions.T
    left, up = upright(first, second, third, fourth)
    odd = (np.abs(left) > 0.1) | (up < -0.1)
    left, up = upright(fourth, first, second, third)
    if odd.any() and ((np.abs(left) < 1e-3) & (up > -1e-3)).all():
        warned.of_input(
            "poses: with quaternions w, x, y, z these sensors are rolled or upside down, read as x, y, z, w they are upright: "
            "is w last, as SciPy and ROS write it? Put it first"
        )
