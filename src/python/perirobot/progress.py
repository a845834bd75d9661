"""How far a job is, shown by tqdm where that is installed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


class Bars:
    """A bar for each part of a job, one after the other."""

    def __init__(self, tqdm: Callable[..., Any]) -> None:
        self._tqdm = tqdm
        self._bar: Any = None

    def begin(self, what: str, total: int) -> None:
        """Begins a part with so many things to do, 0 where that is not known."""
        self.close()
        self._bar = self._tqdm(total=total or None, unit=f" {what}", disable=None)

    def update(self, more: int) -> None:
        """So many more are done."""
        self._bar.update(more)

    def say(self, text: str) -> None:
        """Shows how it is, in words."""
        self._bar.set_postfix_str(text)

    def close(self) -> None:
        """Ends the last part."""
        if self._bar is not None:
            self._bar.close()


@contextmanager
def shown(wanted: bool) -> Iterator[Bars | None]:
    """What a job tells how far it is; None where nothing is shown: not wanted, no tqdm."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        wanted = False
    if not wanted:
        yield None
        return
    bars = Bars(tqdm)
    try:
        yield bars
    finally:
        bars.close()
