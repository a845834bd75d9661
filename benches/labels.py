"""Labels of many random cells out of Python, against the sweep of the same cells: python3 benches/labels.py [CELLS [BACKEND]].

Both begin with new studies, so that each puts the cells into voxels itself. Needs the Python package (src/guide/python.md).
"""

import sys
import time

import numpy as np

import perirobot as pr

SHAPE, VOXEL_SIZE_M = (80, 60, 50), 0.05

KEYS = {
    "region": [{"name": "middle", "box": {"min_m": [1, 0.8, 0], "max_m": [3, 2.8, 2.4]}}],
    "sensor": [
        {
            "name": "camera",
            "kind": "rgbd",
            "fov_deg": [87, 58],
            "resolution_px": [320, 180],
            "range_m": [0.3, 6],
            "poses": [
                {
                    "name": "wall",
                    "x_m": {"start": 0.4, "stop": 3.6, "step": 0.8},
                    "y_m": 0.15,
                    "z_m": [1.6, 2.3],
                    "facing": [0, 1, -0.4],
                }
            ],
        }
    ],
}


def cells(count: int) -> dict[str, pr.Cell]:
    """Each has a floor, eight boxes and a person, none of them before the cameras."""
    random, made = np.random.default_rng(1), {}
    for number in range(count):
        occupied, person = np.zeros((2, *SHAPE), bool)
        occupied[:, :, 0] = True
        for _ in range(8):
            x, y, z = random.integers([0, 16, 1], [70, 50, 30])
            dx, dy, dz = random.integers(3, 14, 3)
            occupied[x : x + dx, y : y + dy, z : z + dz] = True
        x, y = random.integers([20, 20], [60, 50])
        person[x - 4 : x + 4, y - 2 : y + 2, 1:35] = True
        made[f"cell {number}"] = pr.Cell(occupied, VOXEL_SIZE_M, people=person)
    return made


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    backend = sys.argv[2] if len(sys.argv) > 2 else "auto"
    made = cells(count)
    begin = time.perf_counter()
    rows = len(pr.Study(KEYS, scenes=made).sweep(backend, progress=False))
    swept = time.perf_counter()
    labels = sum(view.labels.size for view in pr.Study(KEYS, scenes=made).each_labels(backend=backend, progress=False))
    end = time.perf_counter()
    sweep_s, labels_s = swept - begin, end - swept
    poses = labels // (count * int(np.prod(SHAPE)))
    print(f"{count} cells of {np.prod(SHAPE):,} voxels, {poses} poses each, backend {backend}")
    print(f"sweep: {sweep_s:.1f} s for {rows} rows; labels: {labels_s:.1f} s for {labels:,} voxels; ratio {labels_s / sweep_s:.2f}")


main()
