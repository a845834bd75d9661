"""Maps that real sensors recorded, scored against the truth of a study."""

from __future__ import annotations

import os
from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import _perirobot
from .checks import array, index, length, three
from .labels import Labels
from .recordings import cloud_file
from .result import Result
from .study import Study
from .table import Column, Table

if TYPE_CHECKING:
    import pandas


class ScoredMap(Result):
    """What a recorded map scores, a row for each region, and why it does not call occupied what is there."""

    def __init__(self, columns: dict[str, Column], reasons: dict[str, Column]) -> None:
        super().__init__(columns)
        self._reasons = Table(reasons)

    def reasons(self) -> pandas.DataFrame:
        """How many of ``fn + uo`` of each region have which reason: the columns region, reason (``beside``: the map has something a
        voxel off; ``said_free``; ``hidden``: something stands before it from every place where a sensor was, ``object`` says what;
        ``not_measured``), object, voxels_occupied and, of those, voxels_human. Needs pandas.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> scored = pr.score_map(study.labels("camera:right-wall/8/1"), truth=study)
        >>> scored.reasons().groupby("reason").voxels_human.sum()
        """
        return self._reasons.to_pandas()


def score_map(
    recorded: str | PathLike[str] | Labels | ArrayLike,
    truth: Study,
    region: str | None = None,
    *,
    origin_m: Sequence[float] | None = None,
    voxel_size_m: float | None = None,
    pose: Sequence[float] = (0.0, 0.0, 0.0, 0.0),
    sensor_m: Sequence[float] | None = None,
    topic: str | None = None,
    message: int | None = None,
    scene: str | None = None,
    snapshot: int = 0,
) -> ScoredMap:
    """Scores what real sensors recorded against the truth of one scene at one moment, as ``perirobot score`` does.

    >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
    >>> recorded = study.labels("camera:right-wall/8/1")    # or the name of a file
    >>> pr.score_map(recorded, truth=study, region="human").to_pandas()[["tp", "fp", "fn"]]

    The study's own sensors are not cast. A voxel of the study is occupied if a part of an occupied voxel of the map lies in it,
    free if all of it is covered by free ones, else unknown. The points of a cloud mark their voxels, and free those between them
    and the sensor.

    :param recorded: a file: an OctoMap (.bt, .ot), labels (.npz), a point cloud (.pcd, .ply) or a ROS 2 bag (.mcap); or labels in memory: what
        :meth:`Study.labels` gives, or an array of shape (nx, ny, nz), int8 or uint8 with 1 occupied, 0 free, -1 or 255 unknown, or
        bool with what is not occupied free; or points in metres, float, shape (n, 3) or (rows, columns, 3), such as those of
        :func:`perirobot.depth_points`.
    :param truth: the study that knows what was there.
    :param region: the name of a region; all by default.
    :param origin_m: of an array: the lowest corner of voxel [0, 0, 0] in the frame of the recording, metres.
    :param voxel_size_m: of an array: edge of a voxel, metres.
    :param pose: where the frame of the recording stands in the world: x, y, z in metres and its yaw in degrees (from x towards
        y), or x, y, z and a quaternion w, x, y, z. Only point clouds can be tilted.
    :param sensor_m: of a file or points: where the sensor was, in the frame of the recording. A point cloud is carved from there, by default
        from where a .pcd says, else from the frame's origin; of a map it tells what was hidden.
    :param topic: of a bag: the topic of its point clouds, needed where it has several.
    :param message: of a bag: the number of a message, counted from 0; by default all of them are one recording.
    :param scene: the scene that was recorded; the first by default.
    :param snapshot: at which of its moments.
    :returns: a row for each region, with the columns of ``results.csv``, and :meth:`ScoredMap.reasons`.
    :raises ValueError: what is wrong with the file or an argument.
    """
    frame = [float(number) for number in array("pose", pose, np.float64).ravel()]
    words = (frame, scene, index("snapshot", snapshot), region)
    native = truth._native
    if isinstance(recorded, (str, PathLike)):
        if origin_m is not None or voxel_size_m is not None:
            raise ValueError("origin_m, voxel_size_m: belong to arrays, a file says both itself")
        asked = (three("sensor_m", sensor_m), topic, None if message is None else index("message", message))
        return ScoredMap(*map(dict, _perirobot.score_file(native, os.fspath(recorded), None, asked, words)))
    if topic is not None or message is not None:
        raise ValueError("topic, message: belong to files, and this is an array")
    labels: Any = recorded
    if not isinstance(recorded, Labels):
        points = array("recorded", labels)
        are_labels = origin_m is not None or voxel_size_m is not None
        if points.dtype.kind == "f" and (points.ndim < 3 or not are_labels):
            if are_labels:
                raise ValueError("origin_m, voxel_size_m: belong to labels, and these are points")
            cloud = (three("sensor_m", sensor_m), None, None)
            return ScoredMap(*map(dict, _perirobot.score_file(native, "recorded.pcd", cloud_file("recorded", points), cloud, words)))
    if sensor_m is not None:
        raise ValueError("sensor_m: belongs to files and points, and this is an array of labels")
    if isinstance(recorded, Labels):
        labels = recorded.labels
        origin_m = recorded.origin_m.tolist() if origin_m is None else origin_m
        voxel_size_m = recorded.voxel_size_m if voxel_size_m is None else voxel_size_m
    voxels = array("recorded", labels)
    if voxels.ndim != 3:
        raise ValueError(f"recorded: has shape {voxels.shape}, must be (nx, ny, nz)")
    if voxels.dtype not in (np.bool_, np.int8, np.uint8):
        raise ValueError(f"recorded: is of {voxels.dtype}, must be int8, uint8 or bool")
    corner_m = three("origin_m", origin_m)
    if corner_m is None or voxel_size_m is None:
        raise ValueError("origin_m, voxel_size_m: say where voxel [0, 0, 0] begins and how large a voxel is, in metres")
    edge_m = length("voxel_size_m", voxel_size_m)
    # As unsigned bytes, -1 is 255.
    return ScoredMap(*map(dict, _perirobot.score_labels(native, voxels.view(np.uint8), corner_m, edge_m, words)))
