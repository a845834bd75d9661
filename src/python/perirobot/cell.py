"""A cell whose voxels come from numpy arrays, as a scene of a study."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _perirobot
from .checks import array, length, three

_Files = list[tuple[str, Union[str, bytes]]]


class Cell:
    """A still cell in voxels.

    >>> occupied, person = np.zeros((2, 40, 30, 25), bool)
    >>> occupied[:, :, 0] = person[18:22, 22:24, 1:18] = True
    >>> cell = pr.Cell(occupied, 0.1, people=person)

    :param occupied: bool, shape (nx, ny, nz): where anything is, people and robot included or not. Voxel [i, j, k] is the
        i-th along x, the j-th along y, the k-th along z (up).
    :param voxel_size_m: edge of a voxel in metres; a study of cells has the same.
    :param people: the voxels of a person, or those of each: a list of arrays, or an array of shape (people, nx, ny, nz).
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
        self.voxel_size_m = length("voxel_size_m", voxel_size_m)
        corner = three("origin_m", origin_m)
        if corner is None or not np.isfinite(corner).all():
            raise ValueError(f"origin_m = {corner}: must be x, y, z in metres")
        self.key: list[int] = [round(edge / self.voxel_size_m) for edge in corner]
        if not np.allclose(np.multiply(self.key, self.voxel_size_m), corner, rtol=0, atol=1e-6 * self.voxel_size_m):
            raise ValueError(f"origin_m = {corner}: must be multiples of voxel_size_m = {voxel_size_m}")
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
        """The keys of the cell as a scene file of this name, and the maps that they name.

        >>> keys, maps = pr.Cell(np.ones((4, 3, 2), bool), 0.1).files("block")
        >>> keys["object"][0]["octomap"], [name for name, _ in maps]
        """
        objects, maps = [], _Files()
        for part, role, voxels in self._parts:
            maps.append((f"{name}/{part}.bt", voxels))
            objects.append({"name": part, "role": role, "octomap": maps[-1][0]})
        return {"object": objects}, maps

    def bounds_m(self) -> dict[str, list[float]]:
        """The key ``bounds_m`` of a grid of just these voxels: the middles of its first and its last.

        >>> pr.Cell(np.ones((4, 3, 2), bool), 0.1).bounds_m()
        """
        first = [(key + 0.5) * self.voxel_size_m for key in self.key]
        last = [(key + count - 0.5) * self.voxel_size_m for key, count in zip(self.key, self.shape)]
        return {"min": first, "max": last}


def _each(people: Any) -> Sequence[Any]:
    """The voxels of each person."""
    if people is None:
        return []
    if isinstance(people, (list, tuple)) and all(isinstance(person, np.ndarray) for person in people):
        return people
    together = array("people", people)
    return list(together) if together.ndim == 4 else [together]


def _voxels(name: str, voxels: ArrayLike, shape: tuple[int, ...] | None) -> NDArray[np.bool_]:
    given = array(name, voxels)
    if given.ndim != 3 or given.size == 0 or (shape is not None and given.shape != shape):
        raise ValueError(f"{name}: has shape {given.shape}, must be {shape or '(nx, ny, nz)'}")
    if given.dtype != np.bool_:
        raise ValueError(f"{name}: is of {given.dtype}, must be bool")
    return given
