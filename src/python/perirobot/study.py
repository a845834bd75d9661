"""A study: scenes, regions, sensors and their candidate poses."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from os import PathLike
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _perirobot
from .best import Best
from .cell import Cell
from .labels import Labels
from .progress import Bars, shown
from .result import Result

if TYPE_CHECKING:
    import pandas

#: The last axis of what :meth:`Study.evaluate` returns: the counters of ``results.csv``.
COUNTERS = (
    *("tp", "fp", "fn", "tn", "uo", "uf"),
    *("tp_human", "fn_human", "uo_human", "tp_robot", "fn_robot", "uo_robot"),
    *("hit_human", "people", "people_detected", "parts", "parts_detected"),
)

#: Labels that are made at once, in bytes.
_BATCH_BYTES = 64 << 20


class Study:
    """A checked study, from a file (:meth:`load`) or made of Python objects.

    Its scenes are put into voxels when they are first needed, and kept.

    :param keys: the keys of a study file, as dicts and lists; ``scene`` may be left out.
    :param scenes: scenes by their names: cells in voxels, or the keys of a scene file. Where all are cells of one size and
        place, the grid is theirs unless the keys say otherwise.
    :param folder: where files that the keys name are looked for.
    :raises ValueError: what is wrong, by key.
    """

    def __init__(
        self,
        keys: Mapping[str, Any],
        *,
        scenes: Mapping[str, Cell | Mapping[str, Any]] | None = None,
        folder: str | PathLike[str] = ".",
    ) -> None:
        whole, files = dict(keys), list[tuple[str, Union[str, bytes]]]()
        whole["scene"] = list(keys.get("scene", []))
        for name, scene in (scenes or {}).items():
            if isinstance(scene, Cell):
                scene, maps = scene.files(name)
                files += maps
            files.append((f"{name}.toml", _json(scene)))
            whole["scene"].append({"name": name, "file": f"{name}.toml"})
        cells = [scene for scene in (scenes or {}).values() if isinstance(scene, Cell)]
        if cells and len(cells) == len(whole["scene"]):
            whole["grid"] = {**_grid(cells), **keys.get("grid", {})}
        self._native = _perirobot.Study.of(_json(whole), folder, files)

    @classmethod
    def load(
        cls,
        path: str | PathLike[str],
        *,
        voxel_size_m: float | None = None,
        noiseless: bool = False,
        packages: Mapping[str, str | PathLike[str]] | None = None,
        allow_outside: bool = False,
        xacro: bool = False,
    ) -> Study:
        """Reads and checks a study file (TOML) and the scene files that it names.

        :param path: the study file; the files that it names lie in its folder or below.
        :param voxel_size_m: edge of a voxel in metres, instead of the study's.
        :param noiseless: ideal sensors: no noise, no lost returns, no error of the mount.
        :param packages: folders of ROS packages by their names, for the meshes of robots.
        :param allow_outside: read files from other folders, too.
        :param xacro: run the program ``xacro`` for scenes that name ``.xacro`` files, which may run whatever they say.
        :raises ValueError: what is wrong, by file and key.
        """
        named = list((packages or {}).items())
        study = cls.__new__(cls)
        study._native = _perirobot.Study.load(path, voxel_size_m, noiseless, named, allow_outside, xacro)
        return study

    @property
    def voxel_size_m(self) -> float:
        """Edge of a voxel in metres."""
        return self._native.voxel_size_m

    @property
    def repeats(self) -> int:
        """How often everything is scored, each time with other noise."""
        return self._native.repeats

    @property
    def scenes(self) -> list[str]:
        """Names of the scenes."""
        return [name for name, _ in self._native.scenes]

    @property
    def regions(self) -> list[str]:
        """Names of the regions in which voxels are counted."""
        return self._native.regions

    @property
    def combinations(self) -> list[str]:
        """Names of the combinations: sensors that are scored together, or each sensor alone."""
        return self._native.combinations

    def sweep(
        self,
        backend: str = "auto",
        *,
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
    ) -> Result:
        """Scores every choice of poses of every combination, in every snapshot of every scene, all in memory.

        The interpreter's lock is released meanwhile, and Ctrl-C stops the sweep after the batch under way.

        :param backend: "auto" (a hardware GPU if there is one, else the CPU), "cpu", "gpu" or "oracle"; all count the same.
        :param adapter: a Vulkan adapter for the GPU: its number, a part of its name, or "software".
        :param threads: threads of the CPU; all by default.
        :param progress: whether to show a bar, where tqdm is installed.
        :raises ValueError: what is wrong with scenes, meshes or arguments.
        :raises RuntimeError: if the device fails.
        """
        with shown(progress) as bars:
            return Result(dict(self._native.sweep((backend, adapter, threads), bars)))

    @property
    def sensors(self) -> list[str]:
        """Names of the sensors that take poses."""
        return self._native.sensors

    def poses(self, sensor: str | None = None) -> tuple[list[str], NDArray[np.float64]]:
        """The candidate poses of a sensor: their names, and an array of shape (n, 7) as :meth:`evaluate` takes it.

        :param sensor: its name; may be left out where one sensor takes poses.
        """
        names, poses = self._native.poses(self._sensor(sensor))
        return names, np.array(poses).reshape(-1, 7)

    def evaluate(
        self,
        poses: ArrayLike | Mapping[str, ArrayLike],
        sensor: str | None = None,
        *,
        backend: str = "auto",
        adapter: str | None = None,
        threads: int | None = None,
    ) -> NDArray[np.int64]:
        """Counts sensors at poses that the study need not list: what an optimiser asks again and again.

        :param poses: of one sensor: float, shape (n, 7): position x, y, z in metres and quaternion w, x, y, z of the sensor's
            frame (x forward, y left, z up) in the world, or on the link that carries it. Quaternions are made one long. Of
            several sensors, whose evidence is fused: a dict of their names and such arrays, all of n rows.
        :param sensor: its name; may be left out where one sensor takes poses, or where a dict names them.
        :returns: int64, shape (n, moments, repeats, representations, regions, 17). A moment is a snapshot of a scene, scene by
            scene; representations are those of a combination of the sensors in the order of the study, those of the last
            varying fastest; the last axis is :data:`COUNTERS`. At the listed poses these are the counts of :meth:`sweep`; noise
            is drawn by the number of a pose.
        :raises ValueError: if a pose is outside the grid, or the sensor cannot work there.
        """
        if isinstance(poses, Mapping):
            if sensor is not None or not poses:
                raise ValueError("sensor: belongs to an array of poses; a dict has the name of each sensor")
            named = [(name, _rows(rows)) for name, rows in poses.items()]
        else:
            named = [(self._sensor(sensor), _rows(poses))]
        return self._native.evaluate(named, (backend, adapter, threads))

    def labels(
        self,
        poses: str,
        *,
        combination: str | None = None,
        representation: str | None = None,
        scene: str | None = None,
        snapshot: int = 0,
        repeat: int = 0,
        backend: str = "auto",
        adapter: str | None = None,
        threads: int | None = None,
    ) -> Labels:
        """What one choice of poses makes of one moment, voxel by voxel.

        :param poses: as in the column ``poses`` of the results: "camera:right-wall/8/1".
        :param combination: its name, where several have such a choice.
        :param representation: as in the column ``representation``; the first by default.
        :param scene: the scene's name; the first by default.
        :raises ValueError: for a name that is unknown, with the nearest one that is.
        """
        found = self._native.find((poses, combination, representation, scene, snapshot, repeat))
        return next(self._labels([found], (backend, adapter, threads), None))

    def each_labels(
        self,
        poses: Iterable[str] | None = None,
        *,
        combination: str | None = None,
        representation: str | None = None,
        scenes: Iterable[str] | None = None,
        backend: str = "auto",
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
    ) -> Iterator[Labels]:
        """The labels of many choices: scene by scene, snapshot by snapshot, repeat by repeat, choice by choice.

        They are made some at a time, as they are asked for.

        :param poses: names of choices; all of the combination by default.
        :param combination: its name; may be left out where the study has one, or where names of poses tell.
        :param representation: as in the column ``representation``; the first by default.
        :param scenes: names of scenes; all by default.
        """
        if poses is None:
            if combination is None and len(self.combinations) > 1:
                raise ValueError(f"combination: say which of {self.combinations}")
            name = combination or self.combinations[0]
            if name not in self.combinations:
                raise ValueError(f"combination = {name!r}: must be one of {self.combinations}")
            poses = self._native.choices(self.combinations.index(name))[0]
        found = [self._native.find((name, combination, representation, None, 0, 0))[1] for name in poses]
        known = self.scenes
        wanted = known if scenes is None else list(scenes)
        unknown = [name for name in wanted if name not in known]
        if unknown:
            raise ValueError(f"scenes: {unknown[0]!r} must be one of {known}")
        worlds = [world for world, (scene, *_) in enumerate(self._native.grids()) if known[scene] in wanted]
        views = (
            (world, [combination_, choice, way, repeat])
            for world in worlds
            for repeat in range(self.repeats)
            for combination_, choice, way, _ in found
        )

        def all_labels() -> Iterator[Labels]:
            with shown(progress) as bars:
                if bars:
                    bars.begin("labels", len(worlds) * self.repeats * len(found))
                yield from self._labels(views, (backend, adapter, threads), bars)

        return all_labels()

    def choose(
        self,
        out: str | PathLike[str] | None = None,
        *,
        backend: str = "auto",
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
        **keys: Any,
    ) -> Best:
        """Finds the best set of sensors for each size and step of cost, and proves that no other set of the listed poses is better.

        :param out: folder for the files that ``perirobot choose`` writes; a temporary one by default. Other commands take it.
        :param keys: keys of ``[choose]`` instead of the study's: ``at_most=3``, ``objective="f1"``, ``region="robot"``, ``refine=True``.
        :raises ValueError: if nothing is asked, or what is asked is wrong.
        """
        asking = self._native.asking(_json(keys)) if keys else self._native
        best = Best(asking, out)
        with shown(progress) as bars:
            asking.choose(best.folder, (backend, adapter, threads), bars)
        return best

    def judge(
        self,
        best: Best,
        *,
        backend: str = "auto",
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
    ) -> pandas.DataFrame:
        """Decides whether the best set meets the requirements of the study, also with sensors dead and mounts off where they ask for that.

        Does what ``perirobot judge`` does, and writes the same tables into the folder of the set. Needs pandas.

        :returns: a row for each requirement and condition, the columns of ``requirements.csv``; ``verdict`` is PASS or FAIL.
        :raises ValueError: if nothing is required, or the study is not the one of the set.
        """
        import pandas

        with shown(progress) as bars:
            self._native.judge(best.folder, (backend, adapter, threads), bars)
        return pandas.read_csv(os.path.join(best.folder, "requirements.csv"))

    def _labels(
        self,
        views: Iterable[tuple[int, list[int]]],
        backend: tuple[str, str | None, int | None],
        bars: Bars | None,
    ) -> Iterator[Labels]:
        grids, names = self._native.grids(), dict[int, tuple[list[str], list[str]]]()
        at_once = max(1, _BATCH_BYTES // max(int(np.prod(size)) for *_, size in grids))
        left = iter(views)
        while batch := list(islice(left, at_once)):
            for (world, view), labels in zip(batch, self._native.labels(batch, backend, bars)):
                combination, choice, way, repeat = view
                scene, snapshot, origin_m, _ = grids[world]
                if combination not in names:
                    names[combination] = self._native.choices(combination)
                poses, representations = names[combination]
                yield Labels(
                    labels,
                    np.array(origin_m),
                    self.voxel_size_m,
                    self.scenes[scene],
                    snapshot,
                    repeat,
                    self.combinations[combination],
                    poses[choice],
                    representations[way],
                )

    def _sensor(self, name: str | None) -> str:
        known = self.sensors
        if name is None and len(known) != 1:
            raise ValueError(f"sensor: say which of {known}")
        return known[0] if name is None else name


def _rows(poses: ArrayLike) -> NDArray[np.float64]:
    rows = np.ascontiguousarray(poses, np.float64)
    if rows.ndim != 2:
        raise ValueError(f"poses: has shape {rows.shape}, must be (n, 7)")
    return rows


def _grid(cells: list[Cell]) -> dict[str, Any]:
    """The keys of a grid for cells in voxels."""
    sizes = {cell.voxel_size_m for cell in cells}
    if len(sizes) > 1:
        raise ValueError(f"scenes: cells have voxels of {sorted(sizes)} m, must have one size")
    bounds = [cell.bounds_m() for cell in cells]
    grid: dict[str, Any] = {"voxel_size_m": sizes.pop()}
    if all(other == bounds[0] for other in bounds):
        grid["bounds_m"] = bounds[0]
    return grid


def _json(keys: Mapping[str, Any]) -> str:
    """Keys as text; arrays of numpy are lists in it, paths are texts."""

    def plain(value: Any) -> Any:
        if isinstance(value, (np.ndarray, np.generic)):
            return value.tolist()
        if isinstance(value, PathLike):
            return os.fspath(value)
        raise ValueError(f"keys: {value!r} is no number, text, list or dict")

    return json.dumps(keys, default=plain, allow_nan=False)
