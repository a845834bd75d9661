"""A cell whose voxels come from numpy arrays, as a scene of a study."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _perirobot

_Files = list[tuple[str, Union[str, bytes]]]


class Cell:
    """A still cell in voxels.

    :param occupied: bool, shape (nx, ny, nz): where anything is, people and robot included or not. Voxel [i, j, k] is the
        i-th along x, the j-th along y, the k-th along z (up).
    :param voxel_size_m: edge of a voxel in metres; a study of cells has the same.
    :param people: the voxels of a person, or a list with those of each.
    :param robot: the voxels of the robot.
    :param origin_m: lowest corner of voxel [0, 0, 0] in metres, a multiple of the voxel's edge along each axis.
    :raises ValueError: if an array has no voxel, or not the shape of the others.
    """

    def __init__(
        self,
        occupied: ArrayLike,
        voxel_size_m: float,
        *,
        people: ArrayLike | Sequence[ArrayLike] | None = None,
        robot: ArrayLike | None = None,
        origin_m: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        rest = _voxels("occupied", occupied, None)
        self.shape: tuple[int, ...] = rest.shape
        self.voxel_size_m = float(voxel_size_m)
        if not (self.voxel_size_m > 0 and np.isfinite(self.voxel_size_m)):
            raise ValueError(f"voxel_size_m = {voxel_size_m}: must be a length above 0, in metres")
        self.key: list[int] = [round(corner / self.voxel_size_m) for corner in origin_m]
        if not np.allclose(np.multiply(self.key, self.voxel_size_m), origin_m, rtol=0, atol=1e-6 * self.voxel_size_m):
            raise ValueError(f"origin_m = {tuple(origin_m)}: must be multiples of voxel_size_m = {voxel_size_m}")
        self._parts: list[tuple[str, str, bytes]] = []
        bodies = [("robot", "robot", robot)] if robot is not None else []
        bodies += [(f"person {number}", "human", person) for number, person in enumerate(_each(people))]
        for name, role, voxels in bodies:
            body = _voxels(name, voxels, self.shape)
            rest = rest & ~body
            self._add(name, role, body, True)
        self._add("environment", "environment", rest, not self._parts)

    def _add(self, name: str, role: str, voxels: NDArray[np.bool_], is_needed: bool) -> None:
        voxels_as_map = _perirobot.cell_map(voxels, self.voxel_size_m, self.key)
        if voxels_as_map is not None:
            self._parts.append((name, role, voxels_as_map))
        elif is_needed:
            raise ValueError(f"{name}: no voxel is set")

    def files(self, name: str) -> tuple[dict[str, Any], _Files]:
        """The keys of the cell as a scene file of this name, and the maps that they name."""
        objects, maps = [], _Files()
        for part, role, voxels in self._parts:
            maps.append((f"{name}/{part}.bt", voxels))
            objects.append({"name": part, "role": role, "octomap": maps[-1][0]})
        return {"object": objects}, maps

    def bounds_m(self) -> dict[str, list[float]]:
        """The key ``bounds_m`` of a grid of just these voxels: the middles of its first and its last."""
        first = [(key + 0.5) * self.voxel_size_m for key in self.key]
        last = [(key + count - 0.5) * self.voxel_size_m for key, count in zip(self.key, self.shape)]
        return {"min": first, "max": last}


def _each(people: Any) -> Sequence[Any]:
    if people is None:
        return []
    if isinstance(people, (list, tuple)) and np.ndim(people[0] if people else 0) == 3:
        return people
    return [people]


def _voxels(name: str, voxels: ArrayLike, shape: tuple[int, ...] | None) -> NDArray[np.bool_]:
    array = np.asarray(voxels)
    if array.ndim != 3 or array.size == 0 or (shape is not None and array.shape != shape):
        raise ValueError(f"{name}: has shape {array.shape}, must be {shape or '(nx, ny, nz)'}")
    if array.dtype != np.bool_:
        raise ValueError(f"{name}: is of {array.dtype}, must be bool")
    return array
