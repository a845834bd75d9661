"""What sensors make of a cell, voxel by voxel, and what is truly there."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

#: The labels of a voxel. As int8, unknown is -1, as in ``view.npz``.
FREE, OCCUPIED, UNKNOWN = 0, 1, 255


@dataclass(frozen=True, eq=False)
class Labels:
    """The labels of one choice of poses at one moment, over the whole grid.

    Two are equal if all that they have is.
    """

    #: uint8, shape (nx, ny, nz): FREE, OCCUPIED or UNKNOWN; [i, j, k] along x, y, z, x the fastest in memory.
    labels: NDArray[np.uint8]
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
