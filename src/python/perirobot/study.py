"""A study: scenes, regions, sensors and their candidate poses."""

from __future__ import annotations

import copy
import os
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _perirobot
from .best import Best
from .cell import Cell
from .checks import index, json_of, texts
from .device import Backend, words
from .labels import Labels, Truth
from .looks import Looks
from .memory import in_memory
from .page import table
from .poses import Frame, each
from .progress import Bars, shown
from .purchase import Purchase
from .result import Result
from .selection import choices
from .table import Table

if TYPE_CHECKING:
    import pandas

#: Labels that are made at once, in bytes.
_BATCH_BYTES = 64 << 20


#: How a study was made: the constructor of the compiled half, and what it was given.
_Origin = tuple[Literal["from_keys", "load"], tuple[Any, ...]]


class Study(Looks):
    """A checked study, from a file (:meth:`load`) or made of Python objects.

    Its scenes are put into voxels when they are first needed, and kept. A study does not change, so a copy is the study
    itself. Pickled, one that was loaded is read again from its files, which must not have changed; one that was made of
    objects is pickled whole.

    :param keys: the keys of a study file, as dicts and lists; ``scene`` may be left out.
    :param scenes: scenes by their names: cells in voxels, or the keys of a scene file. Where all are cells of one size and
        place, the grid is theirs unless the keys say otherwise. Where a scene file names a table, keys may have arrays: joints of
        people, shape (17, 3) or (moments, 17, 3), as ``mannequin`` or ``keypoints``, and those of a robot by their names, of shape
        (moments,), as ``snapshots.joints_deg``, ``snapshots.joints_m`` or, with ``time_s``, ``snapshots.animation.joints``.
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
        whole, files = in_memory(keys, scenes)
        self._native = _perirobot.Study.from_keys(whole, folder, files)
        self._keys: tuple[Mapping[str, Any], str | PathLike[str]] | None = (copy.deepcopy(dict(keys)), folder)
        # Another process may work in another folder.
        self._origin: _Origin = ("from_keys", (whole, os.path.abspath(folder), files))

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
        step: bool = False,
    ) -> Study:
        """Reads and checks a study file (TOML) and the scene files that it names.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.1, noiseless=True)

        :param path: the study file; the files that it names lie in its folder or below.
        :param voxel_size_m: edge of a voxel in metres, instead of the study's.
        :param noiseless: ideal sensors: no noise, no lost returns, no error of the mount.
        :param packages: folders of ROS packages by their names, for the meshes of robots.
        :param allow_outside: read files from other folders, too.
        :param xacro: run the program ``xacro`` for scenes that name ``.xacro`` files, which may run whatever they say.
        :param step: convert meshes that are ``.step`` or ``.stp`` files: ``pip install cascadio``.
        :raises ValueError: what is wrong, by file and key.
        """
        named = [(name, os.fspath(folder)) for name, folder in (packages or {}).items()]
        return cls._read(os.fspath(path), voxel_size_m, noiseless, named, allow_outside, xacro, step, [])

    @classmethod
    def _read(
        cls,
        path: str,
        voxel_size_m: float | None,
        noiseless: bool,
        named: list[tuple[str, str]],
        allow_outside: bool,
        xacro: bool,
        step: bool,
        texts: list[tuple[str, str]],
    ) -> Study:
        """Reads a study file; texts are in the place of files, by their paths from its folder."""
        study = cls.__new__(cls)
        study._keys = None
        study._native = _perirobot.Study.load(path, voxel_size_m, noiseless, [*named], allow_outside, xacro, step, texts)
        there = [(name, os.path.abspath(folder)) for name, folder in named]
        words = (os.path.abspath(path), voxel_size_m, noiseless, there, allow_outside, xacro, step, texts)
        study._origin = ("load", words)
        return study

    def with_scenes(self, scenes: Mapping[str, Cell | Mapping[str, Any]]) -> Study:
        """The same study, made of objects, with other scenes; what is ready of its sensors is not made again.

        >>> rays = {"fov_deg": [87, 58], "resolution_px": [64, 48], "range_m": [0.3, 6]}
        >>> spot = {"name": "spot", "list": [{"position_m": [1, 1, 1.5], "facing": [1, 1, -1]}]}
        >>> camera = {"name": "camera", "kind": "rgbd", **rays, "poses": [spot]}
        >>> region = {"name": "all", "box": {"min_m": [0, 0, 0], "max_m": [2, 2, 2]}}
        >>> random = np.random.default_rng(1)
        >>> cells = [{"cell": pr.Cell(random.random((20, 20, 20)) < 0.01, 0.1)} for _ in range(3)]
        >>> study = pr.Study({"region": [region], "sensor": [camera]}, scenes=cells[0])
        >>> names, poses = study.poses("camera")
        >>> counts = [study.with_scenes(scenes).evaluate(poses, "camera") for scenes in cells]

        :param scenes: instead of those that the study was made with.
        :raises ValueError: if the study was loaded or unpickled, or what is wrong with the scenes.
        """
        if self._keys is None:
            raise ValueError("scenes: only those of a study made of objects can be replaced, and not after it was pickled")
        keys, folder = self._keys
        whole, files = in_memory(keys, scenes)
        study = Study.__new__(Study)
        study._native, study._keys = self._native.with_keys(whole, folder, files), self._keys
        study._origin = ("from_keys", (whole, os.path.abspath(folder), files))
        return study

    def save(self, folder: str | PathLike[str]) -> str:
        """Writes a study that was made of objects into a folder, for the command line and for :meth:`load`.

        >>> camera = {"name": "camera", "kind": "rgbd", "fov_deg": [87, 58], "resolution_px": [64, 48], "range_m": [0.3, 6]}
        >>> camera["poses"] = [{"name": "spot", "list": [{"position_m": [1, 1, 1.5], "facing": [1, 1, -1]}]}]
        >>> region = {"name": "all", "box": {"min_m": [0, 0, 0], "max_m": [2, 2, 2]}}
        >>> cell = pr.Cell(np.random.default_rng(1).random((20, 20, 20)) < 0.01, 0.1)
        >>> pr.Study({"region": [region], "sensor": [camera]}, scenes={"cell": cell}).save("out/own")

        :param folder: gets ``study.toml``, the scenes, and the files that they read; made if needed.
        :returns: the path of the study file.
        :raises ValueError: if the study was loaded, or another file is in the place of one of these.
        """
        kind, (first, *_) = self._origin
        if kind == "load":
            raise ValueError(f"{first}: the study is in this file already")
        self._native.save(os.fspath(folder))
        return os.path.join(folder, "study.toml")

    def __copy__(self) -> Study:
        return self

    def __deepcopy__(self, memo: object) -> Study:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (*self._origin, self._native.read_files())

    def __repr__(self) -> str:
        file = self._origin[1][0] if self._origin[0] == "load" else "made in memory"
        counts = {"scenes": self.scenes, "regions": self.regions, "combinations": self.combinations}
        return f"<perirobot.Study {file}: {', '.join(f'{what} {len(names)}' for what, names in counts.items())}>"

    def _repr_html_(self) -> str:
        """What it has by name, as notebooks show it."""
        rows = {"scenes": self.scenes, "regions": self.regions, "combinations": self.combinations}
        named = [(what, len(names), ", ".join(names[:20]) + ", …" * (len(names) > 20)) for what, names in rows.items()]
        return table(repr(self)[1:-1], ("", "count", "names"), named)

    @property
    def warnings(self) -> list[str]:
        """What is odd about the study and its scenes, all that :class:`InputWarning` tells a part of."""
        return [f"{scene}: {text}" for scene, text in self._native.warnings()]

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

    @property
    def sensors(self) -> list[str]:
        """Names of the sensors that take poses."""
        return self._native.sensors

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
        return self._native.evaluate(named, frame == "optical", words(backend, adapter, threads))

    def truth(self, scene: str | None = None, snapshot: int = 0) -> Truth:
        """What is truly there at one moment, voxel by voxel: with :meth:`each_labels` the targets of a training set.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> truth = study.truth()
        >>> (truth.human & truth.regions["robot"]).sum()

        :param scene: the scene's name; the first by default.
        :raises ValueError: for a scene or a snapshot that the study does not have.
        """
        known, number = self.scenes, index("snapshot", snapshot)
        wanted = known[0] if scene is None else scene
        if wanted not in known:
            raise ValueError(f"scene = {scene!r}: must be one of {known}")
        moments = [count for _, count in self._native.scenes]
        scene_number = known.index(wanted)
        if number >= moments[scene_number]:
            raise ValueError(f"snapshot = {snapshot}: scene {wanted!r} has {moments[scene_number]}, counted from 0")
        world = sum(moments[:scene_number]) + number
        occupied, human, robot, *regions = self._native.truth(world)
        by_name = dict(zip(self.regions, regions))
        origin_m = np.array(self._native.grid(world)[2])
        return Truth(occupied, human, robot, by_name, origin_m, self.voxel_size_m, wanted, number)

    def labels(
        self,
        poses: str,
        *,
        combination: str | None = None,
        representation: str | None = None,
        scene: str | None = None,
        snapshot: int = 0,
        repeat: int = 0,
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
    ) -> Labels:
        """What one choice of poses makes of one moment, voxel by voxel.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> view = study.labels("camera:right-wall/8/1")
        >>> (view.labels == pr.UNKNOWN).sum()

        :param poses: as in the column ``poses`` of the results: "camera:right-wall/8/1".
        :param combination: its name, where several have such a choice.
        :param representation: as in the column ``representation``; the first by default.
        :param scene: the scene's name; the first by default.
        :raises ValueError: for a name that is unknown, with the nearest one that is.
        """
        moment = (index("snapshot", snapshot), index("repeat", repeat))
        found = self._native.find((poses, combination, representation, scene, *moment))
        return next(self._labels([found], words(backend, adapter, threads), None))

    def each_labels(
        self,
        poses: Iterable[str] | None = None,
        *,
        combination: str | None = None,
        representation: str | None = None,
        scenes: Iterable[str] | None = None,
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
    ) -> Iterator[Labels]:
        """The labels of many choices: scene by scene, snapshot by snapshot, repeat by repeat, choice by choice.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> unknown = [(view.labels == pr.UNKNOWN).mean() for view in study.each_labels(combination="camera")]

        They are made some at a time, as they are asked for.

        :param poses: names of choices; all of the combination by default.
        :param combination: its name; may be left out where the study has one, or where names of poses tell.
        :param representation: as in the column ``representation``; the first by default.
        :param scenes: names of scenes; all by default.
        """

        def find(name: str, combination: str | None) -> list[int]:
            return self._native.find((name, combination, representation, None, 0, 0))[1]

        found = choices(self, poses, combination, find)
        known = self.scenes
        wanted = known if scenes is None else texts("scenes", scenes)
        unknown = [name for name in wanted if name not in known]
        if unknown:
            raise ValueError(f"scenes: {unknown[0]!r} must be one of {known}")
        grids = self._native.grids()
        worlds = [world for world, (scene, *_) in enumerate(grids) if known[scene] in wanted]
        # Labels and hits are a byte each.
        at_once = max(1, _BATCH_BYTES // max(2 * int(np.prod(size)) for *_, size in grids))
        views = (
            (world, [combination_, choice, way, repeat])
            for world in worlds
            for repeat in range(self.repeats)
            for combination_, choice, way in found
        )

        def all_labels() -> Iterator[Labels]:
            with shown(progress) as bars:
                if bars:
                    bars.begin("labels", len(worlds) * self.repeats * len(found))
                yield from self._labels(views, words(backend, adapter, threads), bars, at_once)

        return all_labels()

    def choose(
        self,
        out: str | PathLike[str] | None = None,
        *,
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
        **keys: Any,
    ) -> Best:
        """Finds the best set of sensors for each size and step of cost, and proves that no other set of the listed poses is better.

        >>> best = pr.Study.load("scenes/choose.toml", voxel_size_m=0.1).choose(at_most=2)
        >>> best.front()[["at_most", "cost", "poses"]]

        :param out: folder for the files that ``perirobot choose`` writes; a temporary one by default. Other commands take it.
        :param keys: keys of ``[choose]`` instead of the study's: ``at_most=3``, ``objective="f1"``, ``region="robot"``, ``refine=True``.
        :raises ValueError: if nothing is asked, what is asked is wrong, or the cheapest set is asked for (see :meth:`cheapest`).
        """
        best = Best(self, keys, out)
        with shown(progress) as bars:
            best._asking().choose(best.folder, words(backend, adapter, threads), bars)
        return best

    def cheapest(
        self,
        out: str | PathLike[str] | None = None,
        *,
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
        **keys: Any,
    ) -> Purchase:
        """Finds the cheapest set of the listed poses that passes all ``[[require]]``, and proves that no cheaper one does.

        >>> found = pr.Study.load("scenes/cheapest.toml", voxel_size_m=0.2).cheapest()
        >>> found.sentence

        All sensors need a cost. If nothing passes, that is no error: :attr:`Purchase.reasons` says why.

        :param out: folder for the files that ``perirobot choose`` writes; a temporary one by default. Other commands take it.
        :param keys: keys of ``[choose]`` instead of the study's: ``at_most=4``, ``budget=5000``, ``front="speed"``, ``then="f1"``,
            ``then="nearest_unnoticed_m"``.
        :raises ValueError: if nothing is required, or what is asked is wrong.
        """
        purchase = Purchase(self, {"objective": "cost", **keys}, out)
        with shown(progress) as bars:
            purchase._asking().cheapest(purchase.folder, words(backend, adapter, threads), bars)
        return purchase

    def _labels(
        self,
        views: Iterable[tuple[int, list[int]]],
        backend: tuple[str, str | None, int | None],
        bars: Bars | None,
        at_once: int = 1,
    ) -> Iterator[Labels]:
        left = iter(views)
        while batch := list(islice(left, at_once)):
            for view, (labels, hits) in zip(batch, self._native.labels(batch, backend, bars)):
                world, (*_, repeat) = view
                scene, combination, poses, representation = self._native.names_of(view)
                _, snapshot, origin_m, _ = self._native.grid(world)
                words = (scene, snapshot, repeat, combination, poses, representation)
                yield Labels(labels, hits, np.array(origin_m), self.voxel_size_m, *words)

    def _sensor(self, name: str | None) -> str:
        known = self.sensors
        if name is None and len(known) != 1:
            raise ValueError(f"sensor: say which of {known}")
        return known[0] if name is None else name


#: The study that was unpickled last, and of what: a pool of processes pickles it with each of its tasks.
_last: tuple[tuple[Any, ...], Study] | None = None


def _again(kind: Literal["from_keys", "load"], words: tuple[Any, ...], files: list[tuple[str, str]]) -> Study:
    """A study that was pickled; `files` are the hashes of what it had read then."""
    global _last
    made_of = (kind, words, files)
    if _last is None or _last[0] != made_of:
        study = Study.__new__(Study)
        study._origin, study._keys = (kind, words), None
        study._native = getattr(_perirobot.Study, kind)(*words).restore(files)
        _last = (made_of, study)
    return _last[1]
