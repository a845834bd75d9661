"""The best sets of sensors, with the proof that no other set is better."""

from __future__ import annotations

import os
import shutil
import tempfile
import weakref
from os import PathLike
from typing import TYPE_CHECKING

from . import _perirobot
from .progress import shown

if TYPE_CHECKING:
    import pandas


class Best:
    """What :meth:`Study.choose` found: a front of sets, by size and cost."""

    def __init__(self, study: _perirobot.Study, folder: str | PathLike[str] | None) -> None:
        self._study = study
        if folder is None:
            self.folder = tempfile.mkdtemp(prefix="perirobot-")
            # It is there as long as this object.
            weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)
        else:
            self.folder = os.fspath(folder)
            os.makedirs(self.folder, exist_ok=True)

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
        backend: str = "auto",
        *,
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
    ) -> dict[str, int]:
        """Checks the proof with other code: sets are counted again by the plain oracle, and better ones are looked for again.

        :returns: how many ``sets`` were counted again, and how many steps of the front are ``proven`` again, have a ``bound`` that
            was added up again, or are ``open``, as they claim no proof.
        :raises ValueError: what does not hold.
        """
        with shown(progress) as bars:
            counts = self._study.verify(self.folder, (backend, adapter, threads), bars)
        return dict(zip(("sets", "proven", "bound", "open"), counts))

    def _table(self, name: str) -> pandas.DataFrame:
        import pandas

        return pandas.read_csv(os.path.join(self.folder, name))
