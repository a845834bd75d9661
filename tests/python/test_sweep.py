"""Sweeps from Python are those of the command line: the same rows, the same errors, and they can be stopped."""

import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings

import numpy as np
import pandas as pd

import perirobot as pr
from shared import READ, ROOT, STUDIES, program, scenes, tiny_with_a_crumb


class SameIntegers(unittest.TestCase):
    def test_every_study_that_ships_has_the_rows_of_the_command_line(self):
        with tempfile.TemporaryDirectory() as folder:
            copy = scenes(folder)
            studies = [path for path in copy.glob("**/*.toml") if "[[sensor]]" in path.read_text()]
            self.assertEqual({str(path.relative_to(copy)) for path in studies}, set(STUDIES))
            for name, voxel_size_m in STUDIES.items():
                with self.subTest(name):
                    size = [] if voxel_size_m is None else ["--voxel-size", voxel_size_m]
                    out = ["--out", f"{folder}/out/{name}", "--table", "csv", "--backend", "cpu"]
                    swept = program("sweep", copy / name, *out, *size)
                    self.assertEqual(swept.returncode, 0, swept.stderr)
                    study = pr.Study.load(copy / name, voxel_size_m=voxel_size_m)
                    rows = study.sweep("cpu", progress=False).to_pandas()
                    told = pd.read_csv(f"{folder}/out/{name}/results.csv", **READ)
                    pd.testing.assert_frame_equal(rows, told, check_exact=True)

    def test_backends_agree(self):
        study = pr.Study.load(ROOT / "scenes/tiny.toml")
        rows = [study.sweep(backend, progress=False).to_pandas() for backend in ["cpu", "oracle"]]
        rows.append(study.sweep("gpu", adapter="software", progress=False).to_pandas())
        for other in rows[1:]:
            pd.testing.assert_frame_equal(rows[0], other, check_exact=True)


class Tables(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.study = pr.Study.load(ROOT / "scenes/tutorial/study.toml", voxel_size_m=0.2)
        cls.result = cls.study.sweep("cpu", progress=False)

    def test_arrow_has_the_same_rows(self):
        import polars
        import pyarrow

        frame = self.result.to_pandas()
        for table in [self.result.to_arrow(), pyarrow.table(self.result)]:
            back = table.to_pandas()
            texts = [name for name in back if isinstance(back[name].dtype, pd.CategoricalDtype)]
            pd.testing.assert_frame_equal(back.astype({name: "str" for name in texts}), frame, check_exact=True)
        self.assertEqual(polars.DataFrame(self.result)["tp"].to_list(), frame["tp"].to_list())

    def test_polars_reads_rows_where_there_is_no_pyarrow(self):
        done = subprocess.run([sys.executable, "-c", WITHOUT_PYARROW], cwd=ROOT, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_xarray_has_each_row_in_its_place(self):
        frame = self.result.to_pandas()
        for combination in self.study.combinations:
            cube = self.result.to_xarray(combination)
            self.assertEqual(
                tuple(cube["tp"].dims), ("scene", "snapshot", "repeat", "pose", "representation", "region")
            )
            rows = frame[frame.combination == combination]
            self.assertEqual(cube["tp"].size, len(rows))
            for _, row in rows.sample(min(20, len(rows)), random_state=1).iterrows():
                there = cube.sel(
                    scene=row.scene,
                    snapshot=row.snapshot,
                    repeat=row["repeat"],
                    pose=row.poses,
                    representation=row.representation,
                    region=row.region,
                )
                for name in ["tp", "uf", "hit_human", "parts_missed"]:
                    self.assertEqual(there[name].item(), row[name])
                np.testing.assert_equal(there["kappa"].item(), row.kappa)

    def test_xarray_marks_moments_that_a_scene_has_not(self):
        with tempfile.TemporaryDirectory() as folder:
            write(folder, "still.toml", STILL)
            write(folder, "moving.toml", MOVING)
            write(folder, "study.toml", STUDY)
            cube = pr.Study.load(f"{folder}/study.toml").sweep("cpu", progress=False).to_xarray()
        self.assertEqual(cube["tp"].dtype, np.int64)
        self.assertTrue((cube["tp"].sel(scene="still", snapshot=1) == -1).all())
        self.assertTrue((cube["tp"].sel(scene="moving") >= 0).all())
        self.assertTrue(cube["f1"].sel(scene="still", snapshot=1).isnull().all())

    def test_one_of_several_combinations_must_be_named(self):
        with self.assertRaisesRegex(ValueError, "combination: say which of"):
            self.result.to_xarray()
        with self.assertRaisesRegex(ValueError, "combination = 'camra': must be one of"):
            self.result.to_xarray("camra")


WITHOUT_PYARROW = """
import sys
sys.modules["pyarrow"] = None
import numpy as np, polars, perirobot as pr
result = pr.Study.load("scenes/tiny.toml").sweep("cpu", progress=False)
frame = polars.DataFrame(result)
assert frame.columns == list(result.columns)
for name, column in result.columns.items():
    if column.dtype.kind == "f":
        assert frame[name].null_count() == np.isnan(column).sum()
        column = np.where(np.isnan(column), None, column)
    assert frame[name].to_list() == column.tolist(), name
assert frame["false_alarm"].null_count() > 0
"""
STILL = """
[[object]]
name = "box"
role = "human"
box = { size_m = [0.5, 0.5, 0.5] }
"""
MOVING = STILL + "snapshots = { position_m = [[0, 0, 0], [1, 0, 0]] }"
STUDY = """
[[scene]]
file = "still.toml"
[[scene]]
file = "moving.toml"
[[region]]
name = "all"
box = { min_m = [-1, -1, -1], max_m = [2, 1, 1] }
[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [60, 45]
resolution_px = [32, 24]
range_m = [0.1, 8]
[[sensor.poses]]
name = "wall"
list = [{ position_m = [0.5, -2, 0], facing = [0, 1, 0] }]
"""


def write(folder: str, name: str, text: str) -> None:
    (pathlib.Path(folder) / name).write_text(text)


class Errors(unittest.TestCase):
    def test_what_is_wrong_is_a_value_error_with_file_and_key(self):
        with tempfile.TemporaryDirectory() as folder:
            write(folder, "study.toml", STUDY.replace("fov_deg = [60, 45]", "fov_deg = [60, 190]"))
            write(folder, "still.toml", STILL)
            write(folder, "moving.toml", MOVING)
            with self.assertRaisesRegex(ValueError, r"study\.toml: .*fov_deg"):
                pr.Study.load(f"{folder}/study.toml")
        with self.assertRaisesRegex(ValueError, r"missing\.toml"):
            pr.Study.load("missing.toml")
        with self.assertRaisesRegex(ValueError, "^voxel_size_m 100: must be"):
            pr.Study.load(ROOT / "scenes/tiny.toml", voxel_size_m=100.0)
        with self.assertRaisesRegex(ValueError, 'backend = "tpu".*must be "auto"'):
            pr.Study.load(ROOT / "scenes/tiny.toml").sweep("tpu")


class WhileItRuns(unittest.TestCase):
    def test_what_is_odd_about_a_scene_is_warned_of_once(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        study = pr.Study.load(tiny_with_a_crumb(folder.name))
        with self.assertWarnsRegex(UserWarning, '^tiny: object "crumb" is 1.0 mm long, less than a voxel'):
            study.sweep("cpu", progress=False)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            study.sweep("cpu", progress=False)

    def test_ctrl_c_stops_a_sweep(self):
        # A script that a shell runs in the background ignores Ctrl-C, and what it starts with it.
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler))
        study = pr.Study.load(ROOT / "scenes/paper/exp1.toml", voxel_size_m=0.1)
        timer = threading.Timer(2.0, signal.raise_signal, [signal.SIGINT])
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            study.sweep("cpu", progress=False)

    def test_other_threads_go_on_meanwhile(self):
        # This thread could not look while the sweep held the interpreter's lock.
        study = pr.Study.load(ROOT / "scenes/quick.toml")
        sweep = threading.Thread(target=study.sweep, args=["cpu"], kwargs={"progress": False})
        looks = 0
        sweep.start()
        while sweep.is_alive():
            time.sleep(0.001)
            looks += 1
        self.assertGreater(looks, 20)

    def test_tqdm_is_told_of_every_pose(self):
        import tqdm.auto

        told = []

        class Bar(tqdm.auto.tqdm):
            def update(self, n=1):
                told.append(n)
                return super().update(n)

        original, tqdm.auto.tqdm = tqdm.auto.tqdm, Bar
        try:
            result = pr.Study.load(ROOT / "scenes/tiny.toml").sweep("cpu")
        finally:
            tqdm.auto.tqdm = original
        frame = result.to_pandas()
        poses = frame.groupby(["scene", "snapshot", "repeat", "combination", "poses"]).ngroups
        self.assertEqual(sum(told), poses)


class Program(unittest.TestCase):
    def test_exit_codes_are_those_of_the_program(self):
        self.assertEqual(program("--version").stdout.split()[0], "perirobot")
        self.assertEqual(program("sweep", "missing.toml").returncode, 2)

    def test_a_manifest_has_the_command_as_it_was_typed(self):
        with tempfile.TemporaryDirectory() as out:
            program("sweep", "scenes/tiny.toml", "--out", out)
            with open(f"{out}/manifest.json") as file:
                command = json.load(file)["about"]["command"]
            self.assertEqual(command, ["perirobot", "sweep", "scenes/tiny.toml", "--out", out])


if __name__ == "__main__":
    unittest.main()
