"""The best sets of sensors, with the proof that no other set is better."""

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
from .device import Backend, words
from .page import table
from .progress import shown

if TYPE_CHECKING:
    import pandas

    from .study import Study


def _remove(folder: str, process: int) -> None:
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)


class Best:
    """What :meth:`Study.choose` found: a front of sets, by size and cost."""

    def __init__(self, study: Study | None, keys: Mapping[str, Any], folder: str | PathLike[str] | None) -> None:
        self._study, self._keys = study, keys
        if folder is None:
            self.folder = tempfile.mkdtemp(prefix="perirobot-")
            # It is there as long as this object, in the process that made it: a child that was forked has a copy of both.
            weakref.finalize(self, _remove, self.folder, os.getpid())
        else:
            self.folder = os.fspath(folder)
            os.makedirs(self.folder, exist_ok=True)

    @classmethod
    def load(cls, folder: str | PathLike[str], study: Study | None = None, **keys: Any) -> Best:
        """What is in a folder that :meth:`Study.choose` or ``perirobot choose`` has written.

        :param study: the study of the search; by default it is loaded from its file when :meth:`verify` needs it.
        :param keys: keys of ``[choose]`` with which the search was asked instead of the study's.
        :raises ValueError: if the folder is not one of these.
        """
        missing = [name for name in ("choose.json", "front.csv", "sets.csv") if not os.path.isfile(os.path.join(folder, name))]
        if missing:
            cure = "name a folder that Study.choose or `perirobot choose` wrote"
            raise ValueError(f"{os.fspath(folder)}: has no {missing[0]}: {cure}")
        return cls(study, keys, folder)

    def __repr__(self) -> str:
        return f"<perirobot.Best in {self.folder}>"

    def _repr_html_(self) -> str:
        """The front, as notebooks show it."""
        with open(os.path.join(self.folder, "front.csv"), newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        return table(repr(self)[1:-1], header, rows)

    @property
    def currency(self) -> str | None:
        """The unit of all costs, if the study has a ``currency``."""
        with open(os.path.join(self.folder, "choose.json"), encoding="utf-8") as file:
            found: str | None = json.load(file)["asked"].get("currency")
        return found

    def front(self) -> pandas.DataFrame:
        """The best set of each size and step of cost, with its score and the score that no set is above: the columns of
        ``front.csv``. Needs pandas."""
        return self._table("front.csv")

    def sets(self) -> pandas.DataFrame:
        """The sensors of each set, where they stand, and what each is worth: the columns of ``sets.csv``. Needs pandas."""
        return self._table("sets.csv")

    def refined(self) -> pandas.DataFrame | None:
        """The finer poses that were found with ``refine=True``, if any was: the columns of ``refined.csv``. Needs pandas."""
        is_there = os.path.exists(os.path.join(self.folder, "refined.csv"))
        return self._table("refined.csv") if is_there else None

    def verify(
        self,
        backend: Backend = "auto",
        *,
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
    ) -> dict[str, int]:
        """Checks the folder with other code: sets and tables are counted again by the plain oracle, and better sets are looked for again.

        :returns: how many ``sets`` were counted again, and how many steps of the front are ``proven`` again, have a ``bound`` that
            was added up again, or are ``open``, as they claim no proof.
        :raises ValueError: what does not hold.
        """
        asking = self._asking()
        with shown(progress) as bars:
            counts = asking.verify(self.folder, words(backend, adapter, threads), bars)
        return dict(zip(("sets", "proven", "bound", "open"), counts))

    def _asking(self) -> _perirobot.Study:
        """The study with the question of the search."""
        if self._study is None:
            from .study import Study

            file, voxel_size_m, noiseless = _perirobot.origin_of(self.folder)
            if not os.path.exists(file):
                raise ValueError(f"{file}: the study of this folder is not there: name it, as in Best.load(folder, study)")
            self._study = Study.load(file, voxel_size_m=voxel_size_m, noiseless=noiseless)
        native = self._study._native
        return native.asking(json_of("choose", self._keys)) if self._keys else native

    def _table(self, name: str) -> pandas.DataFrame:
        rows: pandas.DataFrame = needed("pandas", "tables").read_csv(os.path.join(self.folder, name))
        return rows
