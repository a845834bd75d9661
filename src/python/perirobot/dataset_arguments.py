"""The arguments of :func:`perirobot.dataset`, checked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike
from typing import Any

from .cell import Cell
from .checks import index, texts
from .study import Study

#: What a data set may have beside the labels; the first three are planes of the truth.
_PLANES = ("occupied", "human", "robot", "regions", "hits")


def study_of(cells: Any, sensors: Mapping[str, Any] | None, folder: str | PathLike[str]) -> Study:
    """The study whose scenes are cells."""
    if isinstance(cells, Study):
        if sensors is not None:
            raise ValueError("sensors: belong to cells, and a study has its own")
        return cells
    if sensors is None:
        raise ValueError("sensors: name the keys of a study with its regions and sensors")
    if not isinstance(cells, Mapping):
        try:
            cells = {f"{number}": cell for number, cell in enumerate(cells)}
        except TypeError:
            raise ValueError(f"cells = {cells!r}: must be cells by their names, a list of cells, or a study") from None
    if not cells:
        raise ValueError("cells: there is none")
    made = {name: cell for name, cell in cells.items() if isinstance(cell, Cell)}
    grid = sensors.get("grid", {}) if isinstance(sensors, Mapping) else {}
    if made and not (isinstance(grid, Mapping) and "bounds_m" in grid):
        (first, one), *_ = made.items()
        for name, cell in made.items():
            if cell.shape != one.shape:
                raise ValueError(
                    f"cells[{name!r}]: has {cell.shape} voxels, {first!r} has {one.shape}: make them equal, "
                    "set bounds_m of [grid], or write a data set for each shape"
                )
    return Study(sensors, scenes=cells, folder=folder)


def planes_of(include: Iterable[str]) -> list[str]:
    """The arrays beside the labels, in their order."""
    asked = texts("include", include)
    unknown = [name for name in asked if name not in _PLANES]
    if unknown:
        raise ValueError(f"include: {unknown[0]!r} must be one of {list(_PLANES)}")
    return [name for name in _PLANES if name in asked]


def shard_of(shard: Any, parts: int) -> tuple[int, int]:
    """The number of the shard, and of how many."""
    try:
        number, of = (index("shard", entry) for entry in shard)
    except (TypeError, ValueError):
        raise ValueError(f"shard = {shard!r}: must be (k, n), with k from 0 to n - 1") from None
    if number >= of:
        raise ValueError(f"shard = {shard!r}: must be (k, n), with k from 0 to n - 1")
    if of > parts:
        raise ValueError(f"shard = {shard!r}: the data set has {parts} parts: use at most {parts} shards, or fewer cells_per_part")
    return number, of
