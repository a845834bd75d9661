"""What sensors make of a cell, voxel by voxel, and what is truly there."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .checks import needed

if TYPE_CHECKING:
    import xarray

#: The labels of a voxel. As int8, unknown is -1, as in ``view.npz``.
FREE, OCCUPIED, UNKNOWN = 0, 1, 255


@dataclass(frozen=True, eq=False)
class Labels:
    """The labels of one choice of poses at one moment, over the whole grid.

    Two are equal if all that they have is.
    """

    #: uint8, shape (nx, ny, nz): FREE, OCCUPIED or UNKNOWN; [i, j, k] along x, y, z, x the fastest in memory.
    labels: NDArray[np.uint8]
    #: bool, of the same shape: the voxels that returns truly come from, wherever they are read.
    hits: NDArray[np.bool_]
    #: Lowest corner of voxel [0, 0, 0] in the world, metres; its middle is half a voxel further.
    origin_m: NDArray[np.float64]
    #: Edge of a voxel, metres.
    voxel_size_m: float
    #: What is looked at, as in the columns of ``results.csv``.
    scene: str
    snapshot: int
    repeat: int
    combination: str
    poses: str
    representation: str

    def __eq__(self, other: object) -> bool:
        # An array would compare itself with this, entry by entry.
        names = (field.name for field in fields(self))
        return isinstance(other, Labels) and all(np.array_equal(getattr(self, name), getattr(other, name)) for name in names)

    def to_xarray(self) -> xarray.Dataset:
        """The arrays ``labels`` and ``hits`` over the axes x, y, z, whose coordinates are the middles of voxels in the world,
        metres. Needs xarray.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> cell = study.labels("camera:right-wall/8/1").to_xarray()
        >>> (cell["labels"] == pr.UNKNOWN).mean("z")
        """
        words = ("scene", "snapshot", "repeat", "combination", "poses", "representation")
        named = {name: getattr(self, name) for name in words}
        planes = {"labels": self.labels, "hits": self.hits}
        cell: xarray.Dataset = _dataset(planes, self.origin_m, self.voxel_size_m, named)
        return cell


@dataclass(frozen=True, eq=False)
class Truth:
    """What is truly there at one moment, over the whole grid: the arrays that :class:`Labels` of the moment are compared with.

    Arrays are bool, shape (nx, ny, nz); [i, j, k] along x, y, z, x the fastest in memory.
    """

    #: Voxels of all objects that count: environment, robot and people.
    occupied: NDArray[np.bool_]
    #: Voxels of people.
    human: NDArray[np.bool_]
    #: Voxels of the robot.
    robot: NDArray[np.bool_]
    #: Voxels of each region of the study, by its name. Only these are counted.
    regions: dict[str, NDArray[np.bool_]]
    #: Lowest corner of voxel [0, 0, 0] in the world, metres; its middle is half a voxel further.
    origin_m: NDArray[np.float64]
    #: Edge of a voxel, metres.
    voxel_size_m: float
    #: Which moment it is.
    scene: str
    snapshot: int

    def to_xarray(self) -> xarray.Dataset:
        """The arrays ``occupied``, ``human`` and ``robot``, and ``regions`` along an axis ``region``, over the axes x, y, z, as in
        :meth:`Labels.to_xarray`. Needs xarray.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> truth = study.truth().to_xarray()
        >>> truth["regions"].sum(["x", "y", "z"])
        """
        planes = {name: getattr(self, name) for name in ("occupied", "human", "robot")}
        cell = _dataset(planes, self.origin_m, self.voxel_size_m, {"scene": self.scene, "snapshot": self.snapshot})
        stacked = (("region", *_AXES), np.stack(list(self.regions.values())))
        named: xarray.Dataset = cell.assign_coords(region=list(self.regions)).assign(regions=stacked)
        return named


#: The axes of an array of voxels.
_AXES = ("x", "y", "z")


def _dataset(arrays: dict[str, NDArray[Any]], origin_m: NDArray[np.float64], voxel_size_m: float, words: dict[str, Any]) -> Any:
    """Arrays of voxels with their axes in metres."""
    shape = next(iter(arrays.values())).shape
    middles = {axis: origin_m[i] + (np.arange(shape[i]) + 0.5) * voxel_size_m for i, axis in enumerate(_AXES)}
    variables = {name: (_AXES, array) for name, array in arrays.items()}
    cell = needed("xarray", "tables").Dataset(variables, middles, {**words, "voxel_size_m": voxel_size_m})
    for axis in _AXES:
        cell[axis].attrs["units"] = "m"
    return cell
