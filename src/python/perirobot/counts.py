"""The counts of choices of poses, and their scores."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _perirobot
from .checks import array

#: The last axis of what :meth:`Study.evaluate` returns: the counters of ``results.csv``.
COUNTERS = (
    *("tp", "fp", "fn", "tn", "uo", "uf"),
    *("tp_human", "fn_human", "uo_human", "tp_robot", "fn_robot", "uo_robot"),
    *("hit_human", "people", "people_detected", "parts", "parts_detected"),
    *("twice", "hit_human_twice"),
)


def score(counts: ArrayLike, name: str) -> NDArray[np.float64]:
    """A score of counts. Add up the counts of several moments first: that gives the pooled score of ``scores.csv``.

    >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
    >>> names, poses = study.poses("camera")
    >>> counts = study.evaluate(poses[:8], "camera")
    >>> pr.score(counts.sum(axis=(1, 2)), "f1")        # over all moments and repeats

    :param counts: int64, shape (..., 19): the last axis is :data:`COUNTERS`.
    :param name: as in the columns of the results: "f1", "kappa", "human_seen", "human_claimed", "people_detected",
        "parts_detected", "unknown", "false_alarm" or "seen_twice".
    :returns: float64, shape (...); NaN where a score has no value.
    :raises ValueError: for another name or shape.
    """
    given = array("counts", counts, np.int64)
    if given.shape[-1:] != (len(COUNTERS),):
        raise ValueError(f"counts: has shape {given.shape}, must be (..., {len(COUNTERS)}): its last axis is COUNTERS")
    rows = np.ascontiguousarray(given.reshape(-1, len(COUNTERS)))
    return _perirobot.score(name, rows).reshape(given.shape[:-1])
