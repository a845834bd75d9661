"""The rules of rays in plain Python, for tests that count by themselves."""

import math
from collections.abc import Iterator

VOXEL_M = 0.1
NEVER = 2**31 - 1


def quantised(value: float) -> int:
    """To the nearest whole number, ties away from zero."""
    return int(math.copysign(math.floor(abs(value) + 0.5), value))


def path(
    origin_q16: list[int], direction_q16: list[int], shape: tuple[int, ...]
) -> Iterator[tuple[int, tuple[int, ...]]]:
    """The voxels that a ray enters inside a grid, each with the distance in 1/65536 voxels, as the rules have it."""
    voxel, step, period, due = [], [], [], []
    for at, along in zip(origin_q16, direction_q16):
        part = at & 0xFFFF
        ahead = 65536 - part if along > 0 else part
        each = min(NEVER, 2**32 // abs(along)) if along else NEVER
        voxel.append(at >> 16)
        step.append(1 if along > 0 else -1)
        period.append(each)
        due.append(ahead * each >> 16 if along else NEVER)
    while True:
        axis = due.index(min(due))
        distance = due[axis]
        if distance >= NEVER:
            return
        voxel[axis] += step[axis]
        due[axis] += period[axis]
        if not 0 <= voxel[axis] < shape[axis]:
            return
        yield distance, tuple(voxel)
