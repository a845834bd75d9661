"""Warnings: their classes, and the line that they point at, which is the caller's and not one of the package."""

from __future__ import annotations

import re
import sys
import warnings

#: Kinds of warnings about scenes that one warning has.
_MOST_LINES = 5


class InputWarning(UserWarning):
    """Something about a study, its scenes, results or an argument that its user may not expect."""


class DeviceWarning(UserWarning):
    """A GPU failed or is not used; the CPU works instead."""


def of_input(text: str) -> None:
    """Warns of something about the input."""
    _warn(text, InputWarning)


def of_device(text: str) -> None:
    """Warns of a device."""
    _warn(text, DeviceWarning)


def of_scenes(odd: list[tuple[str, str]], where: str = "study.warnings lists all of them") -> None:
    """Warns of what is odd about scenes, pairs of a name and words, in one warning with a line for each kind, and where all are."""
    kinds: dict[str, list[tuple[str, str]]] = {}
    for scene, text in odd:
        kinds.setdefault(re.sub(r"\d+(\.\d+)?", "#", text), []).append((scene, text))
    lines = []
    for alike in kinds.values():
        scene, text = alike[0]
        more = len({name for name, _ in alike} - {scene})
        same = all(other == text for _, other in alike)
        others = f" (and {more} more scenes{'' if same else ', with other numbers'})" if more else ""
        lines.append(f"{scene}: {text}{others}")
    if len(lines) > _MOST_LINES:
        lines[_MOST_LINES - 1 :] = [f"{len(lines) - _MOST_LINES + 1} more kinds of warnings"]
    if len(odd) > len(lines):
        lines.append(where)
    of_input("\n".join(lines))


def _warn(text: str, category: type[Warning]) -> None:
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_globals.get("__package__") == __package__:
        level, frame = level + 1, frame.f_back
    warnings.warn(text, category, stacklevel=level)
