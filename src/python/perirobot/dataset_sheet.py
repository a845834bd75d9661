"""The sheet of a data set: what it is made of, for programs and for people."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from . import _perirobot
from .labels import FREE, OCCUPIED, UNKNOWN

if TYPE_CHECKING:
    from .samples import Dataset
    from .study import Study

_CELL = ["moment", "z", "y", "x"]
_VIEW = ["moment", "repeat", "pose", "z", "y", "x"]

#: The arrays, their types and axes on the disk, and what they have.
_ARRAYS: dict[str, dict[str, Any]] = {
    "labels": {"dtype": "uint8", "axes": _VIEW, "what": "labels of voxels"},
    "occupied": {"dtype": "bool", "axes": _CELL, "what": "voxels of all objects"},
    "human": {"dtype": "bool", "axes": _CELL, "what": "voxels of people"},
    "robot": {"dtype": "bool", "axes": _CELL, "what": "voxels of the robot"},
    "regions": {"dtype": "bool", "axes": ["moment", "region", "z", "y", "x"], "what": "voxels of each region"},
    "hits": {"dtype": "bool", "axes": _VIEW, "what": "voxels that returns truly come from"},
}


def new_sheet(
    study: Study,
    first: _perirobot.Moments,
    chosen: list[list[int]],
    planes: list[str],
    cells_per_part: int | None,
    default: int,
) -> dict[str, Any]:
    """The sheet of a data set that is not there yet."""
    native = study._native
    says = json.loads(_perirobot.identity(native, first))
    scenes = native.scenes
    number, _, way = chosen[0]
    names, representations = native.choices(number)
    poses = [names[choice] for _, choice, _ in chosen]
    per_part = min(len(scenes), default if cells_per_part is None else cells_per_part)
    *_, size = first.grids()[0]
    return {
        "format": 1,
        "what": "labels of voxels that sensors make of robot cells, by perirobot",
        "perirobot": _perirobot.VERSION,
        "shape": size,
        "voxel_size_m": study.voxel_size_m,
        "label_values": {"free": FREE, "occupied": OCCUPIED, "unknown": UNKNOWN},
        "arrays": {name: _ARRAYS[name] for name in ["labels", *planes]},
        "cells_per_part": per_part,
        "parts": -(-len(scenes) // per_part),
        "repeats": study.repeats,
        "combination": study.combinations[number],
        "representation": representations[way],
        "regions": study.regions,
        "poses": poses,
        "placements": _placements(study, poses),
        **says,
        "scenes": scenes,
    }


def _placements(study: Study, poses: list[str]) -> list[list[dict[str, Any]]]:
    """Where the sensors of choices of poses are, if they take poses: in the world, or on the link that carries them."""
    known: dict[str, dict[str, Any]] = {}
    for sensor in study.sensors:
        for name, (*at, w, x, y, z) in zip(*study._native.poses(sensor)):
            known[f"{sensor}:{name}"] = {"pose": f"{sensor}:{name}", "position_m": at, "quaternion_wxyz": [w, x, y, z]}
    return [[known.get(name, {"pose": name}) for name in choice.split(";")] for choice in poses]


def describe(data: Dataset) -> str:
    """The sheet for people, of a data set that is finished."""
    sheet = data.sheet
    moments = sum(count for _, count in sheet["scenes"])
    voxels = sum(data.counts.values())
    lines = [
        "# Labels of robot cells",
        "",
        f"Made by perirobot {sheet['perirobot']}, rules {sheet['semantics_version']}, seed {sheet['seed']}. Read it by",
        "`perirobot.open_dataset(folder)`, or its files by `numpy.load`; `dataset.json` has the keys of the study.",
        "",
        f"- {len(data)} samples: {len(data.scenes)} cells, {moments} moments, {sheet['repeats']} repeats, {len(data.poses)} choices",
        f"  of poses of {sheet['combination']!r} as {sheet['representation']!r}.",
        f"- A sample has {' × '.join(map(str, data.shape))} voxels along x, y, z (up), of {data.voxel_size_m} m.",
        f"- Regions: {', '.join(data.regions)}.",
        "",
        "| array | type | axes on the disk | contents |",
        "|---|---|---|---|",
        *(
            f"| `{name}` | {array['dtype']} | {', '.join(array['axes'])} | {array['what']} |"
            for name, array in sheet["arrays"].items()
        ),
        "",
        "| label | value | voxels | share |",
        "|---|---:|---:|---:|",
        *(
            f"| {label} | {value} | {data.counts[label]} | {data.counts[label] / max(1, voxels):.4f} |"
            for label, value in sheet["label_values"].items()
        ),
        "",
        "| sensor | kind | poses | rays |",
        "|---|---|---:|---:|",
        *(f"| {one['name']} | {one['kind']} | {one['poses']} | {one['rays_per_pose']} |" for one in sheet["sensors"]),
        "",
        f"SHA-256 over all files: `{data.sha256}`",
        "",
    ]
    return "\n".join(lines)
