"""A data set of many small cells, against the sweep of the same cells: python3 benches/dataset.py [CELLS [FOLDER]].

Writes the labels of CELLS cells in 100 poses; the run is killed once, and goes on. Compares 200 random samples with `Study.labels`,
reads all samples by torch's DataLoader if torch is installed, and then sweeps and writes a tenth of the cells, alternately.
FOLDER is removed at the end; it takes 4 GB for 10,000 cells. Needs the Python package (src/guide/python.md).
"""

import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import numpy as np

import perirobot as pr

SHAPE, VOXEL_SIZE_M = (20, 15, 12), 0.2

KEYS = {
    # The whole cell, so that the sweep counts the voxels that are written: of smaller regions it casts fewer rays.
    "region": [{"name": "cell", "box": {"min_m": [0, 0, 0], "max_m": [4, 3, 2.4]}}],
    "sensor": [
        {
            "name": "camera",
            "kind": "rgbd",
            "fov_deg": [87, 58],
            "resolution_px": [80, 50],
            "range_m": [0.3, 6],
            "poses": [
                {
                    "name": "wall",
                    "x_m": {"start": 0.2, "stop": 3.8, "step": 0.4},
                    "y_m": [0.1, 0.3],
                    "z_m": {"start": 0.7, "stop": 1.5, "step": 0.2},
                    "facing": [0, 1, -0.4],
                }
            ],
        }
    ],
}


def cells(count: int) -> list[pr.Cell]:
    """Each has a floor, two boxes and a person, none of them before the cameras."""
    random, made = np.random.default_rng(1), []
    for _ in range(count):
        occupied, person = np.zeros((2, *SHAPE), bool)
        occupied[:, :, 0] = True
        for _ in range(2):
            x, y, z = random.integers([0, 4, 1], [16, 12, 8])
            dx, dy, dz = random.integers(1, 5, 3)
            occupied[x : x + dx, y : y + dy, z : z + dz] = True
        x, y = random.integers([4, 5], [16, 13])
        person[x - 1 : x + 1, y, 1:9] = True
        made.append(pr.Cell(occupied, VOXEL_SIZE_M, people=person))
    return made


def run(what: str, count: int, folder: pathlib.Path) -> subprocess.Popen[str]:
    """A process that sweeps the cells, or writes them as a data set."""
    words = [sys.executable, __file__, what, str(count), str(folder)]
    return subprocess.Popen(words, stdout=subprocess.PIPE, text=True)


def measured(process: subprocess.Popen[str]) -> tuple[float, float, float]:
    """The seconds of a run, those of all cores, and its peak of memory in MB."""
    told, _ = process.communicate()
    if process.returncode:
        sys.exit(f"{process.args} failed: {process.returncode}")
    seconds, core_seconds, megabytes = map(float, told.split()[-3:])
    return seconds, core_seconds, megabytes


def begin_run(what: str, count: int, folder: str) -> None:
    """The run itself. Cells are made before; putting them into voxels counts in both."""
    made = cells(count)
    begin, core_begin = time.perf_counter(), time.process_time()
    if what == "sweep":
        pr.Study(KEYS, scenes={f"{number}": cell for number, cell in enumerate(made)}).sweep(progress=False)
    else:
        pr.dataset(made, KEYS, out=folder, progress=False)
    seconds = (time.perf_counter() - begin, time.process_time() - core_begin)
    print(*seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000)


def write(count: int, folder: pathlib.Path) -> None:
    """Writes the data set; once it has 30 % of its parts, the run is killed in the midst of a part, and goes on."""
    process, begin = run("dataset", count, folder), time.perf_counter()
    parts = -(-count * 100 * int(np.prod(SHAPE)) // (256 << 20))
    while process.poll() is None and len(list(folder.glob("part-*.json"))) < 0.3 * parts:
        time.sleep(0.05)
    time.sleep(1)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    kept = sorted(folder.glob("part-*.json"))
    killed_s, dates = time.perf_counter() - begin, [path.stat().st_mtime_ns for path in kept]
    seconds, _, megabytes = measured(run("dataset", count, folder))
    assert kept and dates == [path.stat().st_mtime_ns for path in kept], "a finished part was made again"
    total = sum(path.stat().st_size for path in folder.iterdir())
    print(f"{count} cells of {np.prod(SHAPE):,} voxels, 100 poses: killed after {killed_s:.1f} s with {len(kept)} parts of {parts},")
    print(f"then {seconds:.1f} s; peak of memory {megabytes:.0f} MB; {total / 1e9:.2f} GB")


def check(count: int, folder: pathlib.Path) -> None:
    """Compares some samples with the labels of the study, and reads all by torch."""
    data = pr.open_dataset(folder)
    study = pr.Study(KEYS, scenes={f"{number}": cell for number, cell in enumerate(cells(count))})
    for number in np.random.default_rng(2).choice(len(data), 200, replace=False):
        of = data.sample(int(number))
        view = study.labels(of.poses, scene=of.scene, snapshot=of.snapshot, repeat=of.repeat)
        np.testing.assert_array_equal(data[int(number)]["labels"], view.labels)
    print(f"200 of {len(data)} samples are those of Study.labels")
    try:
        from torch.utils.data import DataLoader
    except ImportError:
        return
    begin = time.perf_counter()
    read = sum(len(batch["labels"]) for batch in DataLoader(data, batch_size=64, num_workers=2))
    print(f"DataLoader with 2 workers: {read / (time.perf_counter() - begin):.0f} samples/s")


def compare(count: int, folder: pathlib.Path, times: int = 4) -> None:
    """Sweeps and writes the same cells, alternately. On a busy machine the seconds of all cores vary least."""
    swept, written = [], []
    for number in range(times):
        swept.append(measured(run("sweep", count, folder))[:2])
        written.append(measured(run("dataset", count, folder / f"{number}"))[:2])
        shutil.rmtree(folder / f"{number}")
    for what, some in (("wall time", 0), ("time of all cores", 1)):
        sweep_s, write_s = (min(times[some] for times in both) for both in (swept, written))
        pairs = ", ".join(f"{one[some] / other[some]:.2f}" for one, other in zip(written, swept))
        print(f"{count} cells, {what}: sweep {sweep_s:.2f} s, data set {write_s:.2f} s; ratio {write_s / sweep_s:.2f}, of pairs {pairs}")


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    with tempfile.TemporaryDirectory(dir=sys.argv[2] if len(sys.argv) > 2 else None) as folder:
        whole, tenth = pathlib.Path(folder) / "whole", pathlib.Path(folder) / "tenth"
        write(count, whole)
        check(count, whole)
        shutil.rmtree(whole)
        os.makedirs(tenth)
        compare(max(1, count // 10), tenth)


if len(sys.argv) > 3:
    begin_run(sys.argv[1], int(sys.argv[2]), sys.argv[3])
else:
    main()
