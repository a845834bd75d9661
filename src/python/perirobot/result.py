"""What a sweep found: a row for each scene, snapshot, repeat, choice of poses, representation and region."""

from __future__ import annotations

import os
from os import PathLike
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from . import _perirobot
from .checks import needed
from .page import table

if TYPE_CHECKING:
    import pandas
    import pyarrow
    import xarray

# Numbers, or names: numbers into a list of them.
_Names = tuple[NDArray[np.int32], list[str]]
_Column = Union[NDArray[np.int64], NDArray[np.float64], _Names]


#: The axes of a cube, and the columns that they come from.
_AXES = {
    "scene": "scene",
    "snapshot": "snapshot",
    "repeat": "repeat",
    "pose": "poses",
    "representation": "representation",
    "region": "region",
}


#: Rows that a notebook shows.
_SHOWN_ROWS = 10


class Result:
    """The rows of a sweep, in the order of ``results.csv`` and with its columns.

    Counts are int64. Scores are float64, NaN where a score has no value (nobody in the region, say).
    """

    def __init__(self, columns: dict[str, _Column]) -> None:
        self._columns = columns

    @staticmethod
    def load(folder: str | PathLike[str]) -> Result:
        """The rows of a finished sweep in a folder that ``perirobot sweep`` or ``choose`` has written.

        :raises ValueError: what is missing there, or does not fit together.
        """
        return Result(dict(_perirobot.results(os.fspath(folder))))

    def __len__(self) -> int:
        return len(self._columns["snapshot"])

    def __repr__(self) -> str:
        return f"<perirobot.{type(self).__name__}: {len(self)} rows>"

    def _repr_html_(self) -> str:
        """The first rows, as notebooks show them."""
        shown = {name: _values(column, slice(_SHOWN_ROWS)) for name, column in self._columns.items()}
        return table(f"{type(self).__name__}: {len(self)} rows", list(shown), zip(*shown.values()))

    @property
    def columns(self) -> dict[str, NDArray[Any]]:
        """The columns by name, each an array of shape (rows,): names as objects, counts int64, scores float64."""
        return {name: _values(column) for name, column in self._columns.items()}

    def to_pandas(self) -> pandas.DataFrame:
        """The rows as pandas reads them from ``results.csv``; needs pandas."""
        frame: pandas.DataFrame = needed("pandas", "tables").DataFrame(self.columns, copy=False)
        return frame

    def to_arrow(self) -> pyarrow.Table:
        """The rows as an Arrow table; names are dictionary-encoded, a score without a value is null. Needs pyarrow."""
        rows: pyarrow.Table = needed("pyarrow", "tables").table(self)
        return rows

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """Hands the rows to whatever takes Arrow's PyCapsules, such as polars or DuckDB, always in the same types."""
        return _perirobot.arrow_stream(list(self._columns.items()))

    def to_xarray(self, combination: str | None = None) -> xarray.Dataset:
        """The rows of one combination over scene, snapshot, repeat, pose, representation and region; needs xarray.

        Where a scene has fewer snapshots than another, its missing ones have counts of -1, and scores without a value.

        :param combination: its name; may be left out where the study has one.
        :raises ValueError: if there is no such combination, or several and none is named.
        """
        module = needed("xarray", "tables")
        known = _values(self._columns["combination"])
        names = list(dict.fromkeys(known))
        if combination is None and len(names) > 1:
            raise ValueError(f"combination: say which of {names}")
        if combination is not None and combination not in names:
            raise ValueError(f"combination = {combination!r}: must be one of {names}")
        name = names[0] if combination is None else combination
        rows = np.flatnonzero(known == name)
        places, coordinates = [], {}
        for axis, named in _AXES.items():
            place, there = _places(self._columns[named], rows)
            places.append(place)
            coordinates[axis] = there
        variables: dict[str, Any] = {}
        for key, column in self._columns.items():
            if key in _AXES.values() or key == "combination":
                continue
            values = _values(column)[rows]
            empty = {"i": -1, "f": np.nan, "O": ""}[values.dtype.kind]
            whole = np.full([len(there) for there in coordinates.values()], empty, values.dtype)
            whole[tuple(places)] = values
            variables[key] = (list(_AXES), whole)
        cube: xarray.Dataset = module.Dataset(variables, coordinates, {"combination": name})
        return cube


def _values(column: _Column, rows: slice = slice(None)) -> NDArray[Any]:
    """Numbers as they are, names as objects; of some rows."""
    if isinstance(column, tuple):
        numbers, names = column
        return np.array(names, object)[numbers[rows]]
    return column[rows]


def _places(column: _Column, rows: NDArray[np.intp]) -> tuple[NDArray[np.intp], list[Any]]:
    """The place of each of some rows among what stands in a column there, which comes in the order of the study."""
    numbers, names = column if isinstance(column, tuple) else (column, None)
    there, places = np.unique(numbers[rows], return_inverse=True)
    return places, [int(number) if names is None else names[number] for number in there]
