"""Tables of named columns, for pandas, Arrow and whatever reads Arrow."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from . import _perirobot
from .checks import needed
from .page import table

if TYPE_CHECKING:
    import pandas
    import pyarrow

# Numbers, or names: numbers into a list of them.
Names = tuple[NDArray[np.int32], list[str]]
Column = Union[NDArray[np.int64], NDArray[np.float64], Names]

#: Rows that a notebook shows.
_SHOWN_ROWS = 10


class Table:
    """Rows with named columns. Counts are int64. Scores are float64, NaN where a score has no value."""

    def __init__(self, columns: dict[str, Column]) -> None:
        self._columns = columns

    def __len__(self) -> int:
        column = next(iter(self._columns.values()))
        return len(column[0]) if isinstance(column, tuple) else len(column)

    def __repr__(self) -> str:
        return f"<perirobot.{type(self).__name__}: {len(self)} rows>"

    def _repr_html_(self) -> str:
        """The first rows, as notebooks show them."""
        shown = {name: values(column, slice(_SHOWN_ROWS)) for name, column in self._columns.items()}
        return table(f"{type(self).__name__}: {len(self)} rows", list(shown), zip(*shown.values()))

    @property
    def columns(self) -> dict[str, NDArray[Any]]:
        """The columns by name, each an array of shape (rows,): names as objects, counts int64, scores float64."""
        return {name: values(column) for name, column in self._columns.items()}

    def to_pandas(self) -> pandas.DataFrame:
        """The rows as pandas reads them from a CSV file of the command line; needs pandas.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> study.sweep().to_pandas().query("region == 'robot'")
        """
        frame: pandas.DataFrame = needed("pandas", "tables").DataFrame(self.columns, copy=False)
        return frame

    def to_arrow(self) -> pyarrow.Table:
        """The rows as an Arrow table; names are dictionary-encoded, a score without a value is null. Needs pyarrow.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> study.sweep().to_arrow().schema
        """
        rows: pyarrow.Table = needed("pyarrow", "tables").table(self)
        return rows

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """Hands the rows to whatever takes Arrow's PyCapsules, such as polars or DuckDB, always in the same types."""
        return _perirobot.arrow_stream(list(self._columns.items()))


def values(column: Column, rows: slice = slice(None)) -> NDArray[Any]:
    """Numbers as they are, names as objects; of some rows."""
    if isinstance(column, tuple):
        numbers, names = column
        return np.array(names, object)[numbers[rows]]
    return column[rows]


#: Columns of words in the tables of the command line, in which nothing is missing: a sensor may be called "NA".
_WORDS = [
    *("scene", "combination", "poses", "representation", "region", "reason", "object", "worst_part"),
    *("sensor", "pose", "group", "on", "place"),
]


def frame(csv: bytes) -> pandas.DataFrame:
    """A table as the command line writes it; needs pandas."""
    pandas = needed("pandas", "tables")
    names = pandas.read_csv(io.BytesIO(csv), nrows=0).columns
    missing = {name: [""] for name in names if name not in _WORDS}
    types = {name: str for name in names if name in _WORDS}
    rows: Any = pandas.read_csv(io.BytesIO(csv), keep_default_na=False, na_values=missing, dtype=types)
    return rows
