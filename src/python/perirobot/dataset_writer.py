"""Writes labels of many cells and poses as a data set, part by part; what is written already is not made again."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from os import PathLike
from typing import Any, Union

import numpy as np

from . import _perirobot, warned
from .cell import Cell
from .checks import index
from .dataset_arguments import planes_of, shard_of, study_of
from .dataset_disk import Disk
from .dataset_files import ArrayFile, open_folder, write_whole
from .dataset_inputs import Inputs
from .dataset_sheet import describe, new_sheet
from .device import Backend, words
from .progress import Bars, shown
from .samples import Dataset, array_name, part_name, read_part
from .selection import choices
from .study import Study

_Scene = Union[Cell, Mapping[str, Any]]

#: Labels that are made at once, in bytes.
_BATCH_BYTES = 32 << 20

#: Bytes of labels of a part, about.
_PART_BYTES = 256 << 20


def dataset(
    cells: Study | Mapping[str, _Scene] | Iterable[_Scene],
    sensors: Mapping[str, Any] | None = None,
    *,
    out: str | PathLike[str],
    poses: Iterable[str] | None = None,
    combination: str | None = None,
    representation: str | None = None,
    include: Iterable[str] = ("occupied", "human", "robot", "regions"),
    cells_per_part: int | None = None,
    shard: tuple[int, int] = (0, 1),
    folder: str | PathLike[str] = ".",
    backend: Backend = "auto",
    adapter: str | None = None,
    threads: int | None = None,
    progress: bool = True,
) -> Dataset:
    """Writes the labels of all choices of poses in all cells, and the truth, as arrays in a folder.

    >>> random = np.random.default_rng(1)
    >>> cells = [pr.Cell(random.random((20, 20, 20)) < 0.01, 0.1) for _ in range(3)]
    >>> spots = [{"position_m": [1, 1, z], "facing": [1, 1, -1]} for z in (1.2, 1.5)]
    >>> camera = {"name": "camera", "kind": "rgbd", "fov_deg": [87, 58], "resolution_px": [64, 48], "range_m": [0.3, 6]}
    >>> region = {"name": "all", "box": {"min_m": [0, 0, 0], "max_m": [2, 2, 2]}}
    >>> sensors = {"region": [region], "sensor": [{**camera, "poses": [{"name": "spots", "list": spots}]}]}
    >>> data = pr.dataset(cells, sensors, out="out/cells")
    >>> len(data), data[5]["labels"].shape, data.counts

    A run that was stopped goes on where it was. Memory holds the cells and a few batches of labels, whatever the number of cells.
    The folder has the sheet of the data set (``README.md``, ``dataset.json``) and, of each part, a file per array.

    :param cells: cells or keys of scenes by their names, or several that are named by their numbers; or a study, whose scenes
        are the cells. All need one number of voxels along each axis: ``bounds_m`` of ``[grid]`` gives one to scenes of any size.
    :param sensors: the keys of a study without its scenes, as :class:`Study` takes them; none if ``cells`` is a study.
    :param out: the folder, made if needed.
    :param poses: names of choices of poses; all of the combination by default.
    :param combination: its name; may be left out where the study has one.
    :param representation: as in the column ``representation``; the first by default.
    :param include: the arrays beside ``labels``: the planes of :class:`Truth`, and ``hits`` of :class:`Labels`.
    :param cells_per_part: cells whose arrays share files; by default about 256 MiB of labels.
    :param shard: (k, n) writes every n-th part from part k on (counted from 0), for n processes or machines with one folder.
    :param folder: where files that the keys name are looked for.
    :returns: the data set; of a shard, the samples that are written so far.
    :raises ValueError: what is wrong with cells, sensors or arguments, if the folder has another data set, or if a file that it
        was made from has changed.
    :raises OSError: if the disk fails; what is complete stays.
    """
    study = study_of(cells, sensors, folder)
    job = _Job(study, os.path.abspath(out), words(backend, adapter, threads))
    job.prepare(poses, combination, representation, planes_of(include), cells_per_part)
    number, of = shard_of(shard, job.sheet["parts"])
    with shown(progress) as bars:
        job.write(range(number, job.sheet["parts"], of), bars)
    done = Dataset(job.out, partial=of > 1)
    job.check_parts(done)
    if not done.missing:
        write_whole(os.path.join(job.out, "README.md"), describe(done).encode())
    return done


class _Job:
    """The parts of a data set, and how they are made."""

    sheet: dict[str, Any]

    def __init__(self, study: Study, out: str, device: tuple[str, str | None, int | None]) -> None:
        self.study, self.out, self.device = study, out, device
        self.first = _perirobot.moments(study._native, 0, 1)
        self.inputs = Inputs(study, out)
        self.odd: list[tuple[str, str]] = []

    def prepare(
        self,
        poses: Iterable[str] | None,
        combination: str | None,
        representation: str | None,
        planes: list[str],
        cells_per_part: int | None,
    ) -> None:
        """Makes the sheet, and the folder; fails if it has the data set of another sheet."""
        native = self.study._native

        def find(name: str, combination: str | None) -> list[int]:
            return _perirobot.find_choice(native, self.first, name, combination, representation)

        self.chosen = choices(self.study, poses, combination, find)
        if not self.chosen or len({number for number, *_ in self.chosen}) > 1:
            raise ValueError("poses: name at least one choice of poses, and those of one combination only")
        per_part = None if cells_per_part is None else index("cells_per_part", cells_per_part)
        if per_part == 0:
            raise ValueError("cells_per_part = 0: must be at least 1")
        *_, size = self.first.grids()[0]
        moments = max(1, native.scenes[0][1])
        of_cell = int(np.prod(size)) * moments * self.study.repeats * len(self.chosen)
        default = max(1, _PART_BYTES // of_cell)
        self.sheet = new_sheet(self.study, self.first, self.chosen, planes, per_part, default)
        self.sheet = open_folder(self.out, self.sheet, is_free=per_part is None)

    def write(self, numbers: Iterable[int], bars: Bars | None) -> None:
        """Writes the parts that are missing."""
        missing, own = [], set(numbers)
        for number in range(self.sheet["parts"]):
            part = read_part(self.out, number)
            if part is not None:
                self.inputs.add_part(part["read"], number)
            elif number in own:
                missing.append(number)
        self.inputs.check()
        if bars and missing:
            samples = sum(count for number in missing for _, count in self.sheet["scenes"][self._scenes(number)])
            bars.begin("labels", samples * self.sheet["repeats"] * len(self.chosen))
        with Disk() as disk:
            for number in missing:
                self._write_part(number, disk, bars)
        if self.odd:
            warned.of_scenes(self.odd, f"{os.path.join(self.out, 'part-*.json')} have all of them")

    def check_parts(self, done: Dataset) -> None:
        """Fails if parts that others wrote meanwhile were made from other files."""
        for part in done._parts:
            self.inputs.add_part(part["read"], part["part"])

    def _scenes(self, number: int) -> slice:
        per_part = self.sheet["cells_per_part"]
        return slice(number * per_part, (number + 1) * per_part)

    def _write_part(self, number: int, disk: Disk, bars: Bars | None) -> None:
        scenes = self._scenes(number)
        moments = _perirobot.moments(self.study._native, scenes.start, self.sheet["cells_per_part"])
        grids, odd = moments.grids(), moments.warnings()
        shape: tuple[int, ...] = tuple(self.sheet["shape"])
        for scene, _, _, size in grids:
            if tuple(size) != shape:
                raise ValueError(
                    f"scene {self.sheet['scenes'][scene][0]!r}: has {tuple(size)} voxels, others have {shape}: "
                    "set bounds_m of [grid], or write a data set for each shape"
                )
        read = self.inputs.study_files()
        self.inputs.add_part(read, number)
        self.odd += odd
        repeats, planes = self.sheet["repeats"], list(self.sheet["arrays"])[1:]
        lead = {"labels": (len(grids), repeats, len(self.chosen)), "regions": (len(grids), len(self.sheet["regions"]))}
        lead["hits"] = lead["labels"]
        files = {}
        for name in ["labels", *planes]:
            dtype = np.uint8 if name == "labels" else np.bool_
            path = os.path.join(self.out, array_name(name, number))
            files[name] = ArrayFile(path, dtype, (*lead.get(name, lead["labels"][:1]), *shape[::-1]))
            disk.opened.append(files[name])
        counts = self._write_labels(moments, files, disk, bars)
        for moment in range(len(grids)):
            truth = moments.truth(moment)
            of_planes = {"occupied": truth[:1], "human": truth[1:2], "robot": truth[2:3], "regions": truth[3:]}
            for name in planes:
                for plane in of_planes.get(name, []):
                    disk.submit(files[name].write, plane.T)
        part: dict[str, Any] = {"part": number, "moments": [(scene, snapshot, at) for scene, snapshot, at, _ in grids]}
        part["counts"] = dict(zip(("free", "occupied", "unknown"), counts))
        part |= {"read": read, "warnings": odd}
        disk.submit(_finish, os.path.join(self.out, part_name(number)), part, files)

    def _write_labels(
        self, moments: _perirobot.Moments, files: dict[str, ArrayFile], disk: Disk, bars: Bars | None
    ) -> list[int]:
        """Writes labels and hits; how many voxels are free, occupied and unknown."""
        count, voxels = len(moments.grids()), int(np.prod(self.sheet["shape"]))
        views = (
            (moment, [*choice, repeat])
            for moment in range(count)
            for repeat in range(self.sheet["repeats"])
            for choice in self.chosen
        )
        left, at_once = list(views), max(1, _BATCH_BYTES // voxels)
        counts = np.zeros(3, np.int64)
        for begin in range(0, len(left), at_once):
            batch = left[begin : begin + at_once]
            labels = disk.rows("labels", (at_once, voxels), np.uint8)[: len(batch)]
            hits = disk.rows("hits", (at_once, voxels), np.bool_)[: len(batch)] if "hits" in files else None
            told = _perirobot.write_labels(self.study._native, moments, batch, (labels, hits), self.device, bars)
            counts += np.sum(told, axis=0)
            disk.submit(files["labels"].write, labels)
            if hits is not None:
                disk.submit(files["hits"].write, hits)
        return [int(number) for number in counts]


def _finish(path: str, part: dict[str, Any], files: Mapping[str, ArrayFile]) -> None:
    """Gives the files of a part their names, and then says that it is finished."""
    part["files"] = {os.path.basename(file.path): file.finish() for file in files.values()}
    write_whole(path, json.dumps(part).encode())
