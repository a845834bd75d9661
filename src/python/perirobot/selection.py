"""Choices of poses of a study by their names."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from .checks import texts

if TYPE_CHECKING:
    from .named import Named

    #: Finds the numbers of combination, choice and representation of a name.
    _Find = Callable[[str, "str | None"], "list[int]"]


def choices(study: Named, poses: Iterable[str] | None, combination: str | None, find: _Find) -> list[list[int]]:
    """The numbers of combination, choice and representation of choices of poses; all of the combination by default."""
    if poses is not None:
        return [find(name, combination)[:3] for name in texts("poses", poses)]
    known = study.combinations
    if combination is None and len(known) > 1:
        raise ValueError(f"combination: say which of {known}")
    name = combination or known[0]
    if name not in known:
        raise ValueError(f"combination = {name!r}: must be one of {known}")
    names = study._native.choices(known.index(name))[0]
    number, _, representation, *_ = find(names[0], name)
    return [[number, choice, representation] for choice in range(len(names))]
