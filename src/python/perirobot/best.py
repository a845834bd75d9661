"""The best sets of sensors, with the proof that no other set is better."""

from __future__ import annotations

import os
from os import PathLike
from typing import TYPE_CHECKING, Any

from . import _perirobot
from .answer import Answer, missing_file
from .device import Backend, words
from .progress import shown

if TYPE_CHECKING:
    import pandas

    from .study import Study


class Best(Answer):
    """What :meth:`Study.choose` found: a front of sets, by size and cost."""

    _SHOWN = "front.csv"

    @classmethod
    def load(cls, folder: str | PathLike[str], study: Study | None = None, **keys: Any) -> Best:
        """What is in a folder that :meth:`Study.choose` or ``perirobot choose`` has written.

        >>> study = pr.Study.load("scenes/choose.toml", voxel_size_m=0.1)
        >>> best = study.choose("out/best", at_most=2)
        >>> pr.Best.load("out/best", study, at_most=2).front()

        :param study: the study of the search; by default it is loaded from its file when :meth:`verify` needs it.
        :param keys: keys of ``[choose]`` with which the search was asked instead of the study's.
        :raises ValueError: if the folder is not one of these.
        """
        if name := missing_file(folder, ["choose.json", "front.csv", "sets.csv"]):
            cure = "name a folder that Study.choose or `perirobot choose` wrote"
            raise ValueError(f"{os.fspath(folder)}: has no {name}: {cure}")
        return cls(study, keys, folder)

    @property
    def currency(self) -> str | None:
        """The unit of all costs, if the study has a ``currency``."""
        return self._currency("choose.json")

    def front(self) -> pandas.DataFrame:
        """The best set of each size and step of cost, with its score and the score that no set is above: the columns of
        ``front.csv``. Needs pandas.

        >>> study = pr.Study.load("scenes/choose.toml", voxel_size_m=0.1)
        >>> study.choose(at_most=2).front()[["at_most", "cost", "poses"]]
        """
        return self._table("front.csv")

    def sets(self) -> pandas.DataFrame:
        """The sensors of each set, where they stand, and what each is worth: the columns of ``sets.csv``. Needs pandas.

        >>> study = pr.Study.load("scenes/choose.toml", voxel_size_m=0.1)
        >>> study.choose(at_most=2).sets()[["sensor", "pose"]]
        """
        return self._table("sets.csv")

    def refined(self) -> pandas.DataFrame | None:
        """The finer poses that were found with ``refine=True``, if any was: the columns of ``refined.csv``. Needs pandas.

        >>> study = pr.Study.load("scenes/choose.toml", voxel_size_m=0.1)
        >>> finer = study.choose(at_most=1, refine=True).refined()
        """
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

        >>> study = pr.Study.load("scenes/choose.toml", voxel_size_m=0.1)
        >>> study.choose(at_most=1).verify()

        :returns: how many ``sets`` were counted again, and how many steps of the front are ``proven`` again, have a ``bound`` that
            was added up again, or are ``open``, as they claim no proof.
        :raises ValueError: what does not hold.
        """
        asking = self._asking()
        with shown(progress) as bars:
            counts = _perirobot.verify(asking, self.folder, words(backend, adapter, threads), bars)
        return dict(zip(("sets", "proven", "bound", "open"), counts))
