"""What choices of poses make of moments, voxel by voxel, and what is truly there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice

import numpy as np

from . import _perirobot
from .checks import index, texts
from .device import Backend, words
from .labels import Labels, Truth
from .named import Named
from .progress import Bars, shown
from .selection import choices

#: Labels that are made at once, in bytes.
_BATCH_BYTES = 64 << 20


class Views(Named):
    """The methods of a study that return voxels."""

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
        occupied, human, robot, *regions = _perirobot.truth(self._native, world)
        by_name = dict(zip(self.regions, regions))
        origin_m = np.array(_perirobot.grid(self._native, world)[2])
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
        found = _perirobot.find(self._native, (poses, combination, representation, scene, *moment))
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
            return _perirobot.find(self._native, (name, combination, representation, None, 0, 0))[1]

        found = choices(self, poses, combination, find)
        known = self.scenes
        wanted = known if scenes is None else texts("scenes", scenes)
        unknown = [name for name in wanted if name not in known]
        if unknown:
            raise ValueError(f"scenes: {unknown[0]!r} must be one of {known}")
        grids = _perirobot.grids(self._native)
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

    def _labels(
        self,
        views: Iterable[tuple[int, list[int]]],
        backend: tuple[str, str | None, int | None],
        bars: Bars | None,
        at_once: int = 1,
    ) -> Iterator[Labels]:
        left = iter(views)
        while batch := list(islice(left, at_once)):
            for view, (labels, hits) in zip(batch, _perirobot.labels(self._native, batch, backend, bars)):
                world, (*_, repeat) = view
                scene, combination, poses, representation = _perirobot.names_of(self._native, view)
                _, snapshot, origin_m, _ = _perirobot.grid(self._native, world)
                words = (scene, snapshot, repeat, combination, poses, representation)
                yield Labels(labels, hits, np.array(origin_m), self.voxel_size_m, *words)
