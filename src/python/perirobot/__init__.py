"""Scores where to put the sensors of a robot cell, with the same integers as the command ``perirobot``.

>>> import perirobot as pr
>>> study = pr.Study.load("scenes/tiny.toml")
>>> result = study.sweep()
>>> result.to_pandas().nlargest(3, "f1")

What is wrong with a study, a scene or an argument is a ``ValueError`` that names file, key and what would be right. A disk
that fails is an ``OSError``, a device that fails a ``RuntimeError``. Warnings are of the classes :class:`InputWarning` and
:class:`DeviceWarning`.
"""

import importlib
from typing import Any

from ._perirobot import VERSION as __version__
from .best import Best
from .cell import Cell
from .counts import COUNTERS, score
from .samples import Dataset, Sample, open_dataset
from .dataset_writer import dataset
from .device import Backend
from .labels import FREE, OCCUPIED, UNKNOWN, Labels, Truth
from .findings import Approach, Picture, Why
from .planner import Planner, plan
from .poses import look_at
from .purchase import Purchase, PurchasedSensor, PurchasedSet, Reason
from .result import Result
from .recorded import ScoredMap, score_map
from .recordings import depth_points
from .study import Study
from .table import Table
from .warned import DeviceWarning, InputWarning

__all__ = [
    *("COUNTERS", "FREE", "OCCUPIED", "UNKNOWN"),
    *("Approach", "Backend", "Best", "Cell", "Dataset", "DeviceWarning", "InputWarning", "Labels", "Picture"),
    *("Planner", "Purchase", "PurchasedSensor", "PurchasedSet", "Reason", "Result", "Sample", "ScoredMap", "Study"),
    *("Table", "Truth", "Why", "__version__", "dataset", "depth_points", "look_at"),
    *("open_dataset", "plan", "score", "score_map"),
]


def __getattr__(name: str) -> Any:
    # It needs gymnasium, which few have installed.
    if name == "gym":
        return importlib.import_module(".gym", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
