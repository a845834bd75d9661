"""The files of a data set: each appears whole or not at all."""

from __future__ import annotations

import glob
import hashlib
import json
import os
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import DTypeLike, NDArray

from .samples import SHEET, read_sheet

#: Unfinished files that nobody has written to for so long are of runs that were killed, seconds.
_STALE_S = 3600


class ArrayFile:
    """An array that is written in order, and gets its name when it is finished."""

    def __init__(self, path: str, dtype: DTypeLike, shape: tuple[int, ...]) -> None:
        self.path = path
        _remove_stale(path)
        self._part = _unfinished(path)
        self._file: BinaryIO = open(self._part, "wb")
        self._hash, self._bytes = hashlib.sha256(), 0
        descr = np.lib.format.dtype_to_descr(np.dtype(dtype))
        header = _Header()
        np.lib.format.write_array_header_1_0(header, {"descr": descr, "fortran_order": False, "shape": shape})
        self._write(header.bytes)

    def write(self, rows: NDArray[Any]) -> None:
        """Writes the next entries."""
        self._write(np.ascontiguousarray(rows).reshape(-1).view(np.uint8).data)

    def finish(self) -> dict[str, Any]:
        """Gives the file its name when the disk has it; its size and hash."""
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()
        os.replace(self._part, self.path)
        return {"bytes": self._bytes, "sha256": self._hash.hexdigest()}

    def abandon(self) -> None:
        """Removes what is not finished."""
        self._file.close()
        if os.path.exists(self._part):
            os.remove(self._part)

    def _write(self, data: Any) -> None:
        self._file.write(data)
        self._hash.update(data)
        self._bytes += len(data)


class _Header:
    """Takes the header of an array."""

    def __init__(self) -> None:
        self.bytes = b""

    def write(self, data: bytes) -> None:
        self.bytes += data


def write_whole(path: str, data: bytes) -> None:
    """Writes a file whole, or leaves the one that is there."""
    with _replaced(path) as file:
        file.write(data)


def open_folder(out: str, sheet: dict[str, Any], is_free: bool) -> dict[str, Any]:
    """Makes the folder of a data set, with its sheet, or checks that it has this sheet; `is_free` if the number of cells in a
    part is that of the folder."""
    if os.path.exists(out) and not os.path.isdir(out):
        raise ValueError(f"out = {out!r}: is a file: name a folder for the data set")
    os.makedirs(out, exist_ok=True)
    new: dict[str, Any] = json.loads(json.dumps(sheet))
    if not os.path.exists(os.path.join(out, SHEET)):
        others = sorted(name for name in os.listdir(out) if not name.startswith("."))
        if others and not os.path.exists(os.path.join(out, SHEET)):
            raise ValueError(f"out = {out!r}: has {others[0]!r} and no {SHEET}: name a new folder, or an empty one")
        write_whole(os.path.join(out, SHEET), json.dumps(new, indent=1).encode())
        return new
    there = read_sheet(out)
    if is_free:
        parts = there.get("cells_per_part")
        if isinstance(parts, int) and parts > 0:
            new |= {"cells_per_part": parts, "parts": -(-len(new["scenes"]) // parts)}
    for key, what in _PARTS.items():
        if there.get(key) != new[key]:
            path = os.path.join(out, SHEET)
            raise ValueError(f"{path}: this data set has {what}: name another folder, or remove this one")
    return new


#: Keys of a sheet by which data sets differ, and what differs then.
_PARTS = {
    "semantics_version": "other rules, of another version of perirobot",
    "scenes": "other cells",
    "cells_sha256": "other cells",
    "study": "other sensors, regions or keys",
    "sensors": "other sensors",
    "seed": "another seed",
    "noiseless": "other noise",
    "shape": "cells of another size",
    "voxel_size_m": "voxels of another size",
    "repeats": "another number of repeats",
    "combination": "another combination",
    "representation": "another representation",
    "poses": "other poses",
    "placements": "other poses",
    "regions": "other regions",
    "arrays": "other arrays",
    "cells_per_part": "another number of cells_per_part",
}


@contextmanager
def _replaced(path: str) -> Iterator[BinaryIO]:
    part = _unfinished(path)
    try:
        with open(part, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    finally:
        if os.path.exists(part):
            os.remove(part)


def _unfinished(path: str) -> str:
    folder, name = os.path.split(path)
    # Machines that share a folder may have the same process numbers.
    return os.path.join(folder, f".{name}.{uuid.uuid4().hex}.part")


def _remove_stale(path: str) -> None:
    folder, name = os.path.split(path)
    for left in glob.glob(os.path.join(glob.escape(folder), f".{glob.escape(name)}.*.part")):
        try:
            if time.time() - os.stat(left).st_mtime > _STALE_S:
                os.remove(left)
        except OSError:
            # Another process was quicker.
            pass
