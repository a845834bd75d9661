"""The disk of a data set: it writes while the next labels are made."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Callable

import numpy as np
from numpy.typing import NDArray

from .dataset_files import ArrayFile


class Disk:
    """A thread that writes while the next labels are made. Only one batch waits for it."""

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1, "perirobot-dataset")
        self._pending: list[Future[Any]] = []
        self._rows: dict[str, list[NDArray[Any]]] = {}
        #: Files that are not finished, which go if something fails.
        self.opened: list[ArrayFile] = []

    def __enter__(self) -> Disk:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self._wait(0)
        finally:
            self._thread.shutdown()
            for file in self.opened:
                file.abandon()

    def rows(self, name: str, shape: tuple[int, int], dtype: Any) -> NDArray[Any]:
        """Memory for a batch, other than that of the batch before."""
        spare = self._rows.setdefault(name, [])
        if len(spare) < 2:
            spare.append(np.empty(shape, dtype))
        else:
            self._wait(1)
            spare.reverse()
        return spare[-1]

    def submit(self, job: Callable[..., None], *arguments: Any) -> None:
        """Writes something after all that was submitted before."""
        self._wait(3)
        self._pending.append(self._thread.submit(job, *arguments))

    def _wait(self, most: int) -> None:
        """Waits until at most so many jobs are left; what failed is raised."""
        while len(self._pending) > most:
            self._pending.pop(0).result()
