"""What a sweep found: a row for each scene, snapshot, repeat, choice of poses, representation and region."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from . import _perirobot

if TYPE_CHECKING:
    import pandas
    import pyarrow
    import xarray

# Numbers, or names: numbers into a list of them.
_Names = tuple[NDArray[np.int32], list[str]]
_Column = Union[NDArray[np.int64], NDArray[np.float64], _Names]


class Result:
    """The rows of a sweep, in the order of ``results.csv`` and with its columns.

    Counts are int64. Scores are float64, NaN where a score has no value (nobody in the region, say).
    """

    def __init__(self, study: _perirobot.Study, columns: dict[str, _Column]) -> None:
        self._study = study
        self._columns = columns

    def __len__(self) -> int:
        return len(self._columns["snapshot"])

    def __repr__(self) -> str:
        return f"<perirobot.Result: {len(self)} rows>"

    @property
    def columns(self) -> dict[str, NDArray[Any]]:
        """The columns by name, each an array of shape (rows,): names as objects, counts int64, scores float64."""
        return {name: _values(column) for name, column in self._columns.items()}

    def to_pandas(self) -> pandas.DataFrame:
        """The rows as pandas reads them from ``results.csv``; needs pandas."""
        import pandas

        return pandas.DataFrame(self.columns, copy=False)

    def to_arrow(self) -> pyarrow.Table:
        """The rows as an Arrow table; names are dictionary-encoded, a score without a value is null. Needs pyarrow."""
        import pyarrow

        def array(column: _Column) -> pyarrow.Array:
            if isinstance(column, tuple):
                return pyarrow.DictionaryArray.from_arrays(*column)
            return pyarrow.array(column, from_pandas=True)

        return pyarrow.table({name: array(column) for name, column in self._columns.items()})

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """Hands the rows to whatever takes Arrow's PyCapsules, such as polars or DuckDB; needs pyarrow."""
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def to_xarray(self, combination: str | None = None) -> xarray.Dataset:
        """The rows of one combination over scene, snapshot, repeat, pose, representation and region; needs xarray.

        Where a scene has fewer snapshots than another, its missing ones have counts of -1, and scores without a value.

        :param combination: its name; may be left out where the study has one.
        :raises ValueError: if there is no such combination, or several and none is named.
        """
        import xarray

        study, names = self._study, self._study.combinations
        if combination is None and len(names) > 1:
            raise ValueError(f"combination: say which of {names}")
        if combination is not None and combination not in names:
            raise ValueError(f"combination = {combination!r}: must be one of {names}")
        number = names.index(combination) if combination is not None else 0
        poses, representations = study.choices(number)
        snapshots = [count for _, count in study.scenes]
        inner = (study.repeats, len(poses), len(representations), len(study.regions))
        rows = np.flatnonzero(_values(self._columns["combination"]) == names[number])
        is_there = np.arange(max(snapshots)) < np.array(snapshots)[:, None]
        variables: dict[str, Any] = {}
        for name, column in self._columns.items():
            if name in ("scene", "snapshot", "repeat", "combination", "poses", "representation", "region"):
                continue
            values = _values(column)
            empty = {"i": -1, "f": np.nan, "O": ""}[values.dtype.kind]
            whole = np.full((len(snapshots), max(snapshots), *inner), empty, values.dtype)
            whole[is_there] = values[rows].reshape(-1, *inner)
            variables[name] = (("scene", "snapshot", "repeat", "pose", "representation", "region"), whole)
        coordinates = {
            "scene": [name for name, _ in study.scenes],
            "snapshot": range(max(snapshots)),
            "repeat": range(study.repeats),
            "pose": poses,
            "representation": representations,
            "region": study.regions,
        }
        return xarray.Dataset(variables, coordinates, {"combination": names[number]})


def _values(column: _Column) -> NDArray[Any]:
    """Numbers as they are, names as objects."""
    if isinstance(column, tuple):
        numbers, names = column
        return np.array(names, object)[numbers]
    return column
