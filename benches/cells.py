"""What a training loop in Python waits for, the best of its runs: python3 benches/cells.py [BACKEND].

Makes a cell of 240,000 voxels of arrays, labels it one choice of poses at a time and all together, and steps through an
environment with two cameras. Needs the Python package with gymnasium (src/guide/python.md).
"""

import sys
import time
from typing import Any, Callable

import numpy as np
from gymnasium.utils.env_checker import check_env

import perirobot as pr
import perirobot.gym

SHAPES = {"large": (80, 60, 50), "small": (40, 30, 25)}


def cell(name: str) -> tuple[Any, Any]:
    """The voxels of a floor and eight boxes, and those of a person."""
    shape, random = SHAPES[name], np.random.default_rng(1)
    occupied, person = np.zeros((2, *shape), bool)
    occupied[:, :, 0] = True
    x, y, z = shape
    for _ in range(8):
        low = random.integers([0, y // 4, 1], [x - 10, y - 10, z - 10])
        high = low + random.integers(2, 10, 3)
        occupied[low[0] : high[0], low[1] : high[1], low[2] : high[2]] = True
    person[x // 2 - 2 : x // 2 + 2, y // 2 - 1 : y // 2 + 1, 1 : 2 * z // 3] = True
    return occupied, person


def keys(resolution_px: tuple[int, int]) -> dict[str, Any]:
    """A camera at ten places, and a region that has the whole cell."""
    wall = {"name": "wall", "x_m": {"start": 0.4, "stop": 3.6, "step": 0.8}, "y_m": 0.15, "z_m": [1.6, 2.3]}
    camera = {"name": "camera", "kind": "rgbd", "fov_deg": [87, 58], "resolution_px": resolution_px, "range_m": [0.3, 6]}
    region = {"name": "cell", "box": {"min_m": [0, 0, 0], "max_m": [4, 3, 2.5]}}
    return {"region": [region], "sensor": [{**camera, "poses": [{**wall, "facing": [0, 1, -0.4]}]}]}


def best(jobs: list[Callable[[], Any]], times: int) -> list[float]:
    """The least seconds of each of some jobs, which take turns."""
    least = [np.inf] * len(jobs)
    for _ in range(times):
        for number, job in enumerate(jobs):
            begin = time.perf_counter()
            job()
            least[number] = min(least[number], time.perf_counter() - begin)
    return least


def main() -> None:
    backend = sys.argv[1] if len(sys.argv) > 1 else "auto"
    occupied, person = cell("large")
    [seconds] = best([lambda: pr.Cell(occupied, 0.05, people=person)], 200)
    print(f"Cell of {occupied.size:,} voxels: {1000 * seconds:.1f} ms")

    for resolution_px in ((320, 180), (80, 50)):
        study = pr.Study(keys(resolution_px), scenes={"cell": pr.Cell(occupied, 0.05, people=person)})
        names = [view.poses for view in study.each_labels(backend=backend, progress=False)]
        singly, together = best(
            [
                lambda: [study.labels(name, backend=backend) for name in names],
                lambda: list(study.each_labels(names, backend=backend, progress=False)),
            ],
            40,
        )
        each = [1000 * seconds / len(names) for seconds in (singly, together)]
        print(f"{resolution_px}: labels {each[0]:.2f} ms, each_labels {each[1]:.2f} ms a choice; ratio {singly / together:.2f}")

    occupied, person = cell("small")
    study = pr.Study(keys((160, 100)), scenes={"cell": pr.Cell(occupied, 0.1, people=person)})
    words: dict[str, Any] = {"sensors": ["camera", "camera"], "backend": backend}
    env, envs = pr.gym.PlaceSensors(study, **words), pr.gym.PlaceSensorsVector(study, 32, **words)
    check_env(pr.gym.PlaceSensors(study, **words))
    for which in (env, envs):
        which.reset(seed=1)
        which.action_space.seed(1)
    actions = [env.action_space.sample() for _ in range(32)]
    step, steps = best([lambda: [env.step(one) for one in actions], lambda: envs.step(np.array(actions))], 60)
    print(f"PlaceSensors: {32 / step:.0f} steps/s; 32 together: {32 / steps:.0f} steps/s")


main()
