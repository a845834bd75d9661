"""Data sets of labels: arrays in a folder, which are mapped into memory where they are read."""

from __future__ import annotations

import bisect
import hashlib
import json
import operator
import os
from collections.abc import Iterator
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

#: What a data set is made of: keys, with the names of the parts that hold it.
SHEET = "dataset.json"

#: Bytes that are hashed at once.
_BLOCK = 1 << 22


def part_name(number: int) -> str:
    """The file that says that a part is finished, and what it holds."""
    return f"part-{number:05}.json"


def array_name(array: str, number: int) -> str:
    """The file of an array of a part."""
    return f"{array}-{number:05}.npy"


class Sample(NamedTuple):
    """What a sample is of, as in the columns of ``results.csv``."""

    scene: str
    snapshot: int
    repeat: int
    poses: str


class Dataset:
    """The samples of a folder that :func:`perirobot.dataset` has written: one for each moment, repeat and choice of poses.

    ``dataset[n]`` is a dict of arrays: ``labels`` (uint8, shape (nx, ny, nz): ``pr.FREE``, ``pr.OCCUPIED`` or ``pr.UNKNOWN``)
    and what the data set includes: ``occupied``, ``human``, ``robot`` and ``hits`` (bool, the same shape), ``regions`` (bool,
    (regions, nx, ny, nz)). The files are mapped, so that only what is read takes memory; writing into an array changes no file.
    Each process maps them when it first reads one: torch's ``DataLoader`` takes a data set as it is, with any number of workers.
    """

    def __init__(self, folder: str | PathLike[str], *, partial: bool = False) -> None:
        #: The folder.
        self.folder = os.path.abspath(folder)
        #: What ``dataset.json`` says.
        self.sheet: dict[str, Any] = read_sheet(self.folder)
        parts = [read_part(self.folder, number) for number in range(self.sheet["parts"])]
        #: The numbers of parts that are not finished.
        self.missing = [number for number, part in enumerate(parts) if part is None]
        if self.missing and not partial:
            count = f"{len(self.missing)} of {len(parts)} parts"
            raise ValueError(f"{self.folder}: {count} are missing: run perirobot.dataset again, or open it with partial=True")
        self._parts = [part for part in parts if part is not None]
        #: Names of the scenes, of the choices of poses, and of the regions.
        self.scenes: list[str] = [name for name, _ in self.sheet["scenes"]]
        self.poses: list[str] = self.sheet["poses"]
        self.regions: list[str] = self.sheet["regions"]
        #: Voxels along x, y and z, and their edge in metres.
        self.shape: tuple[int, int, int] = tuple(self.sheet["shape"])
        self.voxel_size_m: float = self.sheet["voxel_size_m"]
        moments = [len(part["moments"]) for part in self._parts]
        self._per_moment: int = self.sheet["repeats"] * len(self.poses)
        self._ends = [int(end) for end in np.cumsum(moments) * self._per_moment]
        self._maps: dict[int, dict[str, NDArray[Any]]] = {}

    def __len__(self) -> int:
        return self._ends[-1] if self._ends else 0

    def __getitem__(self, number: int) -> dict[str, NDArray[Any]]:
        part, moment, repeat, pose = self._place(number)
        found = {}
        for name, array in self._arrays(part).items():
            one = array[moment, repeat, pose] if name in ("labels", "hits") else array[moment]
            # x is the fastest on the disk.
            found[name] = np.moveaxis(one, (-1, -2, -3), (-3, -2, -1))
        return found

    def __iter__(self) -> Iterator[dict[str, NDArray[Any]]]:
        return (self[number] for number in range(len(self)))

    def __getstate__(self) -> dict[str, Any]:
        # Maps belong to a process.
        return {**self.__dict__, "_maps": {}}

    def __repr__(self) -> str:
        arrays = ", ".join(self.sheet["arrays"])
        return f"<perirobot.Dataset {self.folder}: {len(self)} samples of {self.shape} voxels: {arrays}>"

    @property
    def counts(self) -> dict[str, int]:
        """How many voxels of all samples are free, occupied and unknown."""
        return {label: sum(part["counts"][label] for part in self._parts) for label in self.sheet["label_values"]}

    @property
    def sha256(self) -> str:
        """The hash of the hashes of all files: equal for equal data sets, whoever wrote which part."""
        files = [(name, file["sha256"]) for part in self._parts for name, file in part["files"].items()]
        return hashlib.sha256(json.dumps([self.sheet["cells_sha256"], files]).encode()).hexdigest()

    def sample(self, number: int) -> Sample:
        """What a sample is of.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> data = pr.dataset(study, combination="camera", out="out/labels")
        >>> data.sample(0).poses
        """
        part, moment, repeat, pose = self._place(number)
        scene, snapshot, _ = self._parts[part]["moments"][moment]
        return Sample(self.scenes[scene], snapshot, repeat, self.poses[pose])

    def origin_m(self, number: int) -> NDArray[np.float64]:
        """Lowest corner of voxel [0, 0, 0] of a sample in the world, metres.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> data = pr.dataset(study, combination="camera", out="out/labels")
        >>> data.origin_m(0)
        """
        part, moment, *_ = self._place(number)
        return np.array(self._parts[part]["moments"][moment][2])

    def verify(self) -> None:
        """Reads all files, and compares them with the hashes that were written with them.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> data = pr.dataset(study, combination="camera", out="out/labels")
        >>> data.verify()

        :raises ValueError: for the first file that differs.
        """
        for part in self._parts:
            for name, file in part["files"].items():
                path = os.path.join(self.folder, name)
                if file_sha256(path) != file["sha256"]:
                    raise ValueError(f"{path}: differs from its hash: remove it, and run perirobot.dataset again")

    def _place(self, number: int) -> tuple[int, int, int, int]:
        """Which part, and its moment, repeat and choice of poses."""
        index = operator.index(number)
        if not -len(self) <= index < len(self):
            raise IndexError(f"sample {index}: the data set has {len(self)}")
        index %= len(self)
        part = bisect.bisect_right(self._ends, index)
        within = index - (self._ends[part - 1] if part else 0)
        moment, rest = divmod(within, self._per_moment)
        return (part, moment, *divmod(rest, len(self.poses)))

    def _arrays(self, part: int) -> dict[str, NDArray[Any]]:
        """The arrays of a part, mapped when they are first read. What is written into them is kept in memory only, so that torch
        takes them without a copy and without a warning."""
        if part not in self._maps:
            number = self._parts[part]["part"]
            paths = {name: os.path.join(self.folder, array_name(name, number)) for name in self.sheet["arrays"]}
            self._maps[part] = {name: np.asarray(np.load(path, mmap_mode="c")) for name, path in paths.items()}
        return self._maps[part]


def open_dataset(folder: str | PathLike[str], *, partial: bool = False) -> Dataset:
    """Opens a data set that :func:`perirobot.dataset` has written.

    >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
    >>> written = pr.dataset(study, combination="camera", out="out/labels")
    >>> data = pr.open_dataset("out/labels")
    >>> data.sample(0).poses, (data[0]["labels"] == pr.UNKNOWN).sum()

    :param partial: opens one that is not finished, with the samples of its finished parts.
    :raises ValueError: if there is none, or it is not finished.
    """
    return Dataset(folder, partial=partial)


def read_sheet(folder: str) -> dict[str, Any]:
    """What the data set of a folder is made of."""
    path = os.path.join(folder, SHEET)
    sheet = _json(path)
    if sheet is None:
        raise ValueError(f"{path}: is missing: name a folder that perirobot.dataset has written")
    if sheet.get("format") != 1:
        raise ValueError(f"{path}: format = {sheet.get('format')!r}: must be 1, was another version of perirobot used?")
    return sheet


def read_part(folder: str, number: int) -> dict[str, Any] | None:
    """What a part holds; None if it is not finished."""
    part = _json(os.path.join(folder, part_name(number)))
    if part is None:
        return None
    for name, file in part["files"].items():
        try:
            size = os.stat(os.path.join(folder, name)).st_size
        except FileNotFoundError:
            return None
        if size != file["bytes"]:
            return None
    return part


def _json(path: str) -> dict[str, Any] | None:
    """The keys of a file; None if there is no such file."""
    try:
        with open(path, encoding="utf-8") as file:
            keys = json.load(file)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except ValueError as error:
        raise ValueError(f"{path}: is damaged ({error}): remove it, and run perirobot.dataset again") from None
    if not isinstance(keys, dict):
        raise ValueError(f"{path}: is damaged: remove it, and run perirobot.dataset again")
    return keys


def file_sha256(path: str) -> str:
    """The hash of a file, in hexadecimal."""
    found = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(_BLOCK):
            found.update(block)
    return found.hexdigest()
