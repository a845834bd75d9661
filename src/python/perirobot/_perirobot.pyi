"""What the compiled half offers; the classes of the package are made of it."""

from collections.abc import Callable, Sequence
from os import PathLike

import numpy as np
from numpy.typing import NDArray

_Names = tuple[NDArray[np.int32], list[str]]
_Backend = tuple[str, str | None, int | None]

def run(words: Sequence[str]) -> int: ...

class Study:
    @staticmethod
    def load(
        path: str | PathLike[str],
        voxel_size_m: float | None,
        noiseless: bool,
        packages: list[tuple[str, str | PathLike[str]]],
        allow_outside: bool,
    ) -> Study: ...
    @property
    def voxel_size_m(self) -> float: ...
    @property
    def repeats(self) -> int: ...
    @property
    def scenes(self) -> list[tuple[str, int]]: ...
    @property
    def regions(self) -> list[str]: ...
    @property
    def combinations(self) -> list[str]: ...
    @property
    def jobs(self) -> int: ...
    def choices(self, combination: int) -> tuple[list[str], list[str]]: ...
    def sweep(
        self, backend: _Backend, progress: Callable[[int], object] | None
    ) -> dict[str, NDArray[np.int64] | NDArray[np.float64] | _Names]: ...
