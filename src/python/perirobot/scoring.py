"""Sweeps over the listed poses, and counts of any others."""

from __future__ import annotations

import os
from collections.abc import Mapping
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _perirobot
from .device import Backend, words
from .named import Named
from .poses import Frame, each
from .progress import shown
from .result import Result
from .table import Table


class Scoring(Named):
    """The methods of a study that return counts and scores."""

    def sweep(
        self,
        backend: Backend = "auto",
        *,
        out: str | PathLike[str] | None = None,
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
    ) -> Result:
        """Scores every choice of poses of every combination, in every snapshot of every scene, all in memory.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> study.sweep().to_pandas().query("region == 'human'").nlargest(3, "kappa")
        >>> study.sweep(out="out/quick").scores()

        The interpreter's lock is released meanwhile, and Ctrl-C stops the sweep after the batch under way.

        :param backend: "auto" (a hardware GPU if there is one, else the CPU), "cpu", "gpu" or "oracle"; all count the same.
        :param out: a folder for the files of ``perirobot sweep``, which other commands take. A sweep of the same study that
            was stopped there is finished.
        :param adapter: a Vulkan adapter for the GPU: its number, a part of its name, or "software"; several GPUs with
            commas between them share the sweep.
        :param threads: threads of the CPU; all by default.
        :param progress: whether to show a bar, where tqdm is installed.
        :raises ValueError: what is wrong with scenes, meshes or arguments.
        :raises RuntimeError: if the device fails.
        """
        with shown(progress) as bars:
            if out is None:
                columns, swept = self._native.sweep(words(backend, adapter, threads), bars)
                return Result(dict(columns), swept)
            self._native.sweep_into(os.fspath(out), words(backend, adapter, threads), bars)
        return Result.load(out)

    def baselines(self) -> Table:
        """What simple answers score in each region at each moment: all voxels occupied, all free, nothing seen, and the
        ceiling, which no choice of the listed poses is above. The columns of counts and scores are those of
        ``results.csv``.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> study.baselines().to_pandas()[["region", "baseline", "f1"]]
        """
        return Table(dict(self._native.baselines()))

    def poses(self, sensor: str | None = None) -> tuple[list[str], NDArray[np.float64]]:
        """The candidate poses of a sensor: their names, and an array of shape (n, 7) as :meth:`evaluate` takes it.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> names, poses = study.poses("camera")

        :param sensor: its name; may be left out where one sensor takes poses.
        """
        names, poses = self._native.poses(self._sensor(sensor))
        return names, np.array(poses).reshape(-1, 7)

    def evaluate(
        self,
        poses: ArrayLike | Mapping[str, ArrayLike],
        sensor: str | None = None,
        *,
        frame: Frame = "link",
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
    ) -> NDArray[np.int64]:
        """Counts sensors at poses that the study need not list: what an optimiser asks again and again.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> counts = study.evaluate([0, -1.9, 2, 0.707, 0, 0, 0.707], "camera")
        >>> dict(zip(pr.COUNTERS, counts[0, 0, 0, 0, study.regions.index("robot")]))

        :param poses: of one sensor, in the world, or on the link that carries it: float, shape (n, 7), position x, y, z in
            metres and quaternion w, x, y, z of length 1; or shape (n, 4, 4), matrices that lead from the sensor's frame
            there; or one such pose, shape (7,) or (4, 4); or a table of pandas or polars with the columns x_m, y_m, z_m, qw,
            qx, qy and qz of ``poses.csv``, in any order. Shape (n, k, 7) or (n, k, 4, 4) is k equal sensors, whose evidence
            is fused. Of several different sensors: a dict of their names and such poses, n of each.
        :param sensor: its name; may be left out where one sensor takes poses, or where a dict names them.
        :param frame: which frame of the sensor is turned: "link" (x forward, y left, z up) or "optical" (z forward, x right,
            y down).
        :returns: int64, shape (n, moments, repeats, representations, regions, 19). A moment is a snapshot of a scene, scene by
            scene; representations are those of a combination of the sensors in the order of the study, equal ones in that of
            their listed poses, those of the last varying fastest; the last axis is :data:`COUNTERS`. At the listed poses these
            are the counts of :meth:`sweep`; noise belongs to the pose, whatever other poses are evaluated with it.
        :raises ValueError: if a pose is outside the grid, or the sensor cannot work there.
        """
        if isinstance(poses, Mapping):
            if sensor is not None or not poses:
                raise ValueError("sensor: belongs to an array of poses; a dict has the name of each sensor")
            named = [(name, rows) for name, of_one in poses.items() for rows in each(of_one, name, frame)]
        else:
            name = self._sensor(sensor)
            named = [(name, rows) for rows in each(poses, name, frame)]
        return _perirobot.evaluate(self._native, named, frame == "optical", words(backend, adapter, threads))
