"""A study of dicts and cells as the files that it would be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Union

from .arrays import with_tables
from .cell import Cell
from .checks import json_of
from .recordings import with_recordings

_Files = list[tuple[str, Union[str, bytes]]]


def in_memory(keys: Mapping[str, Any], scenes: Mapping[str, Cell | Mapping[str, Any]] | None) -> tuple[str, _Files]:
    """The keys of a study as JSON, and its files by name: scenes as JSON, maps as bytes."""
    if not isinstance(keys, Mapping):
        raise ValueError(f"keys: must be a dict with the keys of a study, not {keys!r}; Study.load reads a file")
    if scenes is not None and not isinstance(scenes, Mapping):
        raise ValueError("scenes: must be a dict of names, each with a Cell or the keys of a scene")
    keys, recorded = with_recordings(keys)
    whole, files = dict(keys), _Files(recorded)
    if not isinstance(keys.get("scene", []), (list, tuple)) or not isinstance(keys.get("grid", {}), Mapping):
        raise ValueError("keys: scene must be a list of dicts, grid a dict")
    whole["scene"] = list(keys.get("scene", []))
    for name, scene in (scenes or {}).items():
        if isinstance(scene, Cell):
            scene, maps = scene.files(name)
            files += maps
        elif isinstance(scene, Mapping):
            scene, tables = with_tables(name, scene)
            files += tables
        files.append((f"{name}.toml", json_of(f"scenes[{name!r}]", scene)))
        whole["scene"].append({"name": name, "file": f"{name}.toml"})
    cells = [scene for scene in (scenes or {}).values() if isinstance(scene, Cell)]
    if cells and len(cells) == len(whole["scene"]):
        whole["grid"] = {**_grid(cells), **keys.get("grid", {})}
    return json_of("keys", whole), files


def _grid(cells: list[Cell]) -> dict[str, Any]:
    """The keys of a grid for cells in voxels."""
    sizes = {cell.voxel_size_m for cell in cells}
    if len(sizes) > 1:
        raise ValueError(f"scenes: cells have voxels of {sorted(sizes)} m, must have one size")
    bounds = [cell.bounds_m() for cell in cells]
    grid: dict[str, Any] = {"voxel_size_m": sizes.pop()}
    if all(other == bounds[0] for other in bounds):
        grid["bounds_m"] = bounds[0]
    return grid
