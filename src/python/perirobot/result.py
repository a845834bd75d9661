"""What a sweep found: a row for each scene, snapshot, repeat, choice of poses, representation and region."""

from __future__ import annotations

import csv
import os
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _perirobot
from .checks import needed
from .table import Column, Table, frame, values

if TYPE_CHECKING:
    import pandas
    import xarray


#: The axes of a cube, and the columns that they come from.
_AXES = {
    "scene": "scene",
    "snapshot": "snapshot",
    "repeat": "repeat",
    "pose": "poses",
    "representation": "representation",
    "region": "region",
}

#: Columns of ``poses.csv`` that are coordinates of a cube: numbers, and words.
_PLACED = ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]
_WORDS = ["group", "place"]


class Result(Table):
    """The rows of a sweep, in the order of ``results.csv`` and with its columns.

    Counts are int64. Scores are float64, NaN where a score has no value (nobody in the region, say).
    """

    def __init__(self, columns: dict[str, Column], swept: _perirobot.Swept | None = None) -> None:
        super().__init__(columns)
        self._swept = swept

    @staticmethod
    def load(folder: str | PathLike[str]) -> Result:
        """The rows of a finished sweep in a folder that ``perirobot sweep`` or ``choose`` has written.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> result = study.sweep(out="out/quick")
        >>> len(pr.Result.load("out/quick")) == len(result)

        :raises ValueError: what is missing there, or does not fit together.
        """
        columns, swept = _perirobot.results(os.fspath(folder))
        return Result(dict(columns), swept)

    def scores(self) -> pandas.DataFrame:
        """The scores of each choice of poses over moments and repeats, the columns of ``scores.csv``: mean, std, worst, pooled,
        and weighted by how long moments last if the study says so. A row for each scene and, as scene ``*``, for all of
        them. Needs pandas.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> study.sweep().scores().query("scene == '*'").nlargest(3, "kappa_pooled")
        """
        return frame(self._all().scores())

    def poses(self) -> pandas.DataFrame:
        """Where the poses of all sensors are, the columns of ``poses.csv``. Needs pandas.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> study.sweep().poses()
        """
        return frame(self._all().poses())

    def to_xarray(self, combination: str | None = None) -> xarray.Dataset:
        """The rows of one combination over scene, snapshot, repeat, pose, representation and region; needs xarray.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> study.sweep().to_xarray("camera")["kappa"].max("pose")

        Along ``pose`` are the coordinates x_m, y_m, z_m, qw, qx, qy, qz, group and place of ``poses.csv``, for several sensors
        over ``pose`` and ``member``. Where a scene has fewer snapshots than another, its missing ones have counts of -1, and
        scores without a value.

        :param combination: its name; may be left out where the study has one.
        :raises ValueError: if there is no such combination, or several and none is named.
        """
        module = needed("xarray", "tables")
        known = values(self._columns["combination"])
        names = list(dict.fromkeys(known))
        if combination is None and len(names) > 1:
            raise ValueError(f"combination: say which of {names}")
        if combination is not None and combination not in names:
            raise ValueError(f"combination = {combination!r}: must be one of {names}")
        name = names[0] if combination is None else combination
        rows = np.flatnonzero(known == name)
        places, coordinates = [], dict[str, Any]()
        for axis, named in _AXES.items():
            place, there = _places(self._columns[named], rows)
            places.append(place)
            coordinates[axis] = there
        shape = [len(there) for there in coordinates.values()]
        variables: dict[str, Any] = {}
        for key, column in self._columns.items():
            if key in _AXES.values() or key == "combination":
                continue
            entries = values(column)[rows]
            empty = {"i": -1, "f": np.nan, "O": ""}[entries.dtype.kind]
            whole = np.full(shape, empty, entries.dtype)
            whole[tuple(places)] = entries
            variables[key] = (list(_AXES), whole)
        if self._swept is not None:
            coordinates |= _placed(coordinates["pose"], self._swept.poses())
        cube: xarray.Dataset = module.Dataset(variables, coordinates, {"combination": name})
        return cube

    def _all(self) -> _perirobot.Swept:
        if self._swept is None:
            raise ValueError("scores, poses: belong to a sweep, and this is a recorded map")
        return self._swept


def _placed(poses: list[str], csv_bytes: bytes) -> dict[str, Any]:
    """Where the sensors of choices of poses are, as coordinates of a cube."""
    known = {f"{row['sensor']}:{row['pose']}": row for row in csv.DictReader(csv_bytes.decode().splitlines())}
    members = [choice.split(";") for choice in poses]
    if not all(name in known for choice in members for name in choice):
        return {}
    axes: Any = ["pose"] if len(members[0]) == 1 else ["pose", "member"]
    coordinates: dict[str, Any] = {}
    if len(axes) == 2:
        coordinates["member"] = [known[name]["sensor"] for name in members[0]]
    for column in [*_PLACED, *_WORDS]:
        entries = [[known[name][column] for name in choice] for choice in members]
        of_all: Any = np.array(entries, object)
        if column in _PLACED:
            of_all = np.array([[float(entry or "nan") for entry in choice] for choice in entries])
        coordinates[column] = (axes, of_all[:, 0] if len(axes) == 1 else of_all)
    return coordinates


def _places(column: Column, rows: NDArray[np.intp]) -> tuple[NDArray[np.intp], list[Any]]:
    """The place of each of some rows among what stands in a column there, which comes in the order of the study."""
    numbers, names = column if isinstance(column, tuple) else (column, None)
    there, places = np.unique(numbers[rows], return_inverse=True)
    return places, [int(number) if names is None else names[number] for number in there]
