"""A study: scenes, regions, sensors and their candidate poses."""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping
from os import PathLike
from typing import Any, Literal

from . import _perirobot
from .best import Best
from .cell import Cell
from .device import Backend, words
from .looks import Looks
from .memory import in_memory
from .page import table
from .progress import shown
from .purchase import Purchase
from .scoring import Scoring
from .views import Views

#: How a study was made: the constructor of the compiled half, and what it was given.
_Origin = tuple[Literal["from_keys", "load"], tuple[Any, ...]]


class Study(Scoring, Views, Looks):
    """A checked study, from a file (:meth:`load`) or made of Python objects.

    >>> spot = {"name": "spot", "list": [{"position_m": [1, 1, 1.5], "facing": [1, 1, -1]}]}
    >>> camera = {"name": "camera", "kind": "rgbd", "fov_deg": [87, 58], "resolution_px": [64, 48], "range_m": [0.3, 6]}
    >>> region = {"name": "all", "box": {"min_m": [0, 0, 0], "max_m": [2, 2, 2]}}
    >>> table = {"name": "table", "box": {"size_m": [1, 0.5, 0.7]}, "position_m": [1, 1, 0.35]}
    >>> keys = {"grid": {"voxel_size_m": 0.1}, "region": [region], "sensor": [{**camera, "poses": [spot]}]}
    >>> study = pr.Study(keys, scenes={"cell": {"object": [table]}})

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
            _perirobot.choose(best._asking(), best.folder, words(backend, adapter, threads), bars)
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
            _perirobot.cheapest(purchase._asking(), purchase.folder, words(backend, adapter, threads), bars)
        return purchase

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
