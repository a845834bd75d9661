"""The folder of an answer to ``[choose]``: its tables, and the study that asked."""

from __future__ import annotations

import csv
import json
import os
import shutil
import tempfile
import weakref
from collections.abc import Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any

from . import _perirobot
from .checks import json_of, needed
from .page import table

if TYPE_CHECKING:
    import pandas

    from .study import Study


def _remove(folder: str, process: int) -> None:
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)


class Answer:
    """What is in the folder of a search, which is a temporary one unless it is named."""

    #: The table that notebooks show.
    _SHOWN: str

    def __init__(self, study: Study | None, keys: Mapping[str, Any], folder: str | PathLike[str] | None) -> None:
        self._study, self._keys = study, keys
        if folder is None:
            self.folder = tempfile.mkdtemp(prefix="perirobot-")
            # It is there as long as this object, in the process that made it: a child that was forked has a copy of both.
            weakref.finalize(self, _remove, self.folder, os.getpid())
        else:
            self.folder = os.fspath(folder)
            os.makedirs(self.folder, exist_ok=True)

    def __repr__(self) -> str:
        return f"<perirobot.{type(self).__name__} in {self.folder}>"

    def _repr_html_(self) -> str:
        """The front, as notebooks show it."""
        with open(os.path.join(self.folder, self._SHOWN), newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        return table(repr(self)[1:-1], header, rows)

    def _asking(self) -> _perirobot.Study:
        """The study with the question of the search."""
        if self._study is None:
            from .study import Study

            file, voxel_size_m, noiseless = self._origin()
            if not os.path.exists(file):
                kind = type(self).__name__
                raise ValueError(
                    f"{file}: the study of this folder is not there: name it, as in {kind}.load(folder, study)"
                )
            self._study = Study.load(file, voxel_size_m=voxel_size_m, noiseless=noiseless)
        native = self._study._native
        return native.asking(json_of("choose", self._keys)) if self._keys else native

    def _origin(self) -> tuple[str | PathLike[str], float | None, bool]:
        """The study file, and how it was changed: edge of a voxel in metres, whether without noise."""
        return _perirobot.origin_of(self.folder)

    def _currency(self, file: str) -> str | None:
        with open(os.path.join(self.folder, file), encoding="utf-8") as answer:
            found: str | None = json.load(answer)["asked"].get("currency")
        return found

    def _table(self, name: str) -> pandas.DataFrame:
        rows: pandas.DataFrame = needed("pandas", "tables").read_csv(os.path.join(self.folder, name))
        return rows


def missing_file(folder: str | PathLike[str], names: list[str]) -> str | None:
    """The first of some files that a folder does not have."""
    return next((name for name in names if not os.path.isfile(os.path.join(folder, name))), None)
