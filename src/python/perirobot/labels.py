"""What sensors make of a cell, voxel by voxel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: The labels of a voxel. As int8, unknown is -1, as in ``view.npz``.
FREE, OCCUPIED, UNKNOWN = 0, 1, 255


@dataclass(frozen=True)
class Labels:
    """The labels of one choice of poses at one moment, over the whole grid."""

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
