"""How far a job is, shown by tqdm where that is installed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def shown(total: int, unit: str, wanted: bool) -> Iterator[Callable[[int], object] | None]:
    """What a job calls with how many more are finished; None where nothing is shown: not wanted, no tqdm, no terminal."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        wanted = False
    if not wanted:
        yield None
        return
    with tqdm(total=total, unit=f" {unit}", disable=None) as bar:
        yield bar.update
