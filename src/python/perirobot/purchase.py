"""The cheapest set of sensors that passes all requirements, with the proof that no cheaper one does."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

from . import _perirobot
from .answer import Answer, missing_file
from .device import Backend, words
from .progress import shown

if TYPE_CHECKING:
    import pandas

    from .study import Study


@dataclass(frozen=True)
class PurchasedSensor:
    """A sensor of a set: its name, the name of its pose, where that is in words, and what it costs."""

    sensor: str
    pose: str
    place: str
    cost: float


@dataclass(frozen=True)
class PurchasedSet:
    """A set of sensors; ``name`` is its combination and ``poses`` its poses in the tables of the folder, and ``score`` decides
    among sets of the same cost, if ``then`` was asked."""

    name: str
    cost: float
    score: float | None
    sensors: tuple[PurchasedSensor, ...]

    @property
    def poses(self) -> str:
        """The poses of its sensors, joined as in the column ``poses``."""
        return ";".join(f"{one.sensor}:{one.pose}" for one in self.sensors)


@dataclass(frozen=True)
class Reason:
    """Why nothing passes: a requirement, what stands in its way, and what could help."""

    requirement: str
    why: str


class Purchase(Answer):
    """What :meth:`Study.cheapest` found: the cheapest set that passes, and those of its front."""

    _SHOWN = "cheapest.csv"

    @classmethod
    def load(cls, folder: str | PathLike[str], study: Study | None = None, **keys: Any) -> Purchase:
        """What is in a folder that :meth:`Study.cheapest` or ``perirobot choose`` has written.

        >>> study = pr.Study.load("scenes/cheapest.toml", voxel_size_m=0.2)
        >>> found = study.cheapest("out/cheapest", at_most=2)
        >>> pr.Purchase.load("out/cheapest", study, at_most=2).sentence

        :param study: the study of the search; by default it is loaded from its file when :meth:`verify` needs it.
        :param keys: keys of ``[choose]`` with which the search was asked instead of the study's.
        :raises ValueError: if the folder is not one of these.
        """
        if name := missing_file(folder, ["cheapest.json", "cheapest.csv"]):
            cure = "name a folder that Study.cheapest or `perirobot choose` wrote"
            raise ValueError(f"{os.fspath(folder)}: has no {name}: {cure}")
        return cls(study, {"objective": "cost", **keys} if keys else {}, folder)

    @property
    def sentence(self) -> str:
        """The answer in one sentence, the first that ``perirobot choose`` prints."""
        return _perirobot.purchase_sentence(self.folder)

    @property
    def passes(self) -> bool:
        """Whether a set passes all requirements; if not, :attr:`sets` begins with the one that comes nearest."""
        return self._all["set"] is not None

    @property
    def cost(self) -> float | None:
        """What the cheapest set that passes costs; None if none was found."""
        found = self._all["set"]
        return None if found is None else float(found["cost"])

    @property
    def currency(self) -> str | None:
        """The unit of all costs, if the study has a ``currency``."""
        return self._currency("cheapest.json")

    @property
    def proven(self) -> bool:
        """Whether it is proven that no cheaper set passes, or none at all if none was found."""
        return bool(self._all["proven"])

    @property
    def bound(self) -> float | None:
        """No set that passes costs less; None if no allowed set passes."""
        bound: float | None = self._all["no_set_below"]
        return bound

    @property
    def reasons(self) -> list[Reason]:
        """Why nothing passes: all of these together. Empty if a set passes."""
        return [Reason(**one) for one in self._all.get("reasons", [])]

    @property
    def sets(self) -> list[PurchasedSet]:
        """All sets of the answer and its front, each once, the recommended one first."""
        points = self._points
        # The one that comes nearest is recommended if none passes all.
        points.sort(key=lambda point: not (point["aim"] == "all" or "nearest" in point["aim"]))
        found: dict[str, PurchasedSet] = {}
        for one in (_set(point["set"]) for point in points if point["set"]):
            found.setdefault(one.poses, one)
        return list(found.values())

    def front(self) -> pandas.DataFrame:
        """The cheapest set for all requirements, then at each speed or without each requirement, or the one that comes
        nearest: the columns of ``cheapest.csv``. Needs pandas.

        >>> study = pr.Study.load("scenes/cheapest.toml", voxel_size_m=0.2)
        >>> study.cheapest(at_most=2).front()
        """
        return self._table("cheapest.csv")

    def verdicts(self) -> pandas.DataFrame:
        """The verdicts on each set: the columns of ``requirements.csv``; ``verdict`` is PASS or FAIL. Needs pandas.

        >>> study = pr.Study.load("scenes/cheapest.toml", voxel_size_m=0.2)
        >>> study.cheapest(at_most=2).verdicts().query("verdict == 'FAIL'")

        :raises ValueError: if no set was found.
        """
        if missing_file(self.folder, ["requirements.csv"]):
            raise ValueError(f"{self.folder}: no set was found, so there are no verdicts: see reasons")
        return self._table("requirements.csv")

    def verify(
        self,
        backend: Backend = "auto",
        *,
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
    ) -> dict[str, int]:
        """Checks the folder with other code: sets are judged again by the plain oracle, ways in followed again, and cheaper sets looked for again.

        >>> study = pr.Study.load("scenes/cheapest.toml", voxel_size_m=0.2)
        >>> study.cheapest(at_most=2).verify()

        :returns: how many ``sets`` were judged again (one for each row of the front that has one), ``ways`` in followed again,
            claims ``proven`` again, and how many claims are ``open``, as there are too many sets to search plainly.
        :raises ValueError: what does not hold.
        """
        asking = self._asking()
        with shown(progress) as bars:
            counts = _perirobot.verify_cheapest(asking, self.folder, words(backend, adapter, threads), bars)
        return dict(zip(("sets", "ways", "proven", "open"), counts))

    def _origin(self) -> tuple[str, float | None, bool]:
        # An answer without a set has no other file that tells.
        report = self._report
        return report["study"], report["voxel_size_m"], report["noiseless"]

    @property
    def _report(self) -> dict[str, Any]:
        with open(os.path.join(self.folder, "cheapest.json"), encoding="utf-8") as file:
            report: dict[str, Any] = json.load(file)
        return report

    @property
    def _points(self) -> list[dict[str, Any]]:
        points: list[dict[str, Any]] = self._report["points"]
        return points

    @property
    def _all(self) -> dict[str, Any]:
        """The answer for all requirements."""
        return self._points[0]


def _set(found: dict[str, Any]) -> PurchasedSet:
    sensors = tuple(PurchasedSensor(**one) for one in found["sensors"])
    return PurchasedSet(found["name"], found["cost"], found["score"], sensors)
