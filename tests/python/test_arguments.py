"""Mistakes of callers are named in the words of Python, warnings are few and point at the caller; tables of notebooks."""

import os
import pathlib
import subprocess
import sys
import tempfile
import typing
import unittest
import warnings

import numpy as np

import perirobot as pr
import perirobot.warned
import test_labels
from shared import ROOT, tiny_with_a_crumb

TINY = ROOT / "scenes/tiny.toml"


class Mistakes(unittest.TestCase):
    def test_arguments_that_are_wrong_are_named(self):
        study = pr.Study.load(TINY)
        occupied, people = test_labels.Cells.random(1)
        cell, keys = pr.Cell(occupied, 0.1), test_labels.Cells.KEYS
        best = pr.Best.load
        for job, message in [
            (lambda: pr.Study("scenes/tiny.toml"), "keys: must be a dict .* Study.load reads a file"),
            (lambda: pr.Study(keys, scenes=[cell]), "scenes: must be a dict of names"),
            (lambda: pr.Study({**keys, "scene": {"a": 1}}), "scene must be a list of dicts"),
            (lambda: pr.Study({**keys, "seed": None}), "^keys.seed = None: leave the key out"),
            (lambda: pr.Study({**keys, "seed": float("nan")}), "^keys.seed = nan: must be a finite number"),
            (lambda: pr.Study({**keys, 3: 4}), "^keys: 3 must be text"),
            (lambda: pr.Study({**keys, "seed": {1, 2}}), "^keys.seed: {1, 2} must be a number, text, list or dict"),
            (lambda: pr.Study({**keys, "grid": {"voxel": [1, None]}}), r"^keys.grid.voxel\[1\] = None"),
            (lambda: pr.Cell(occupied, "fine"), "voxel_size_m = 'fine': must be a length above 0"),
            (lambda: pr.Cell(occupied, 0.1, origin_m=[0, 0]), r"origin_m = \[0.0, 0.0\]: must be x, y, z"),
            (lambda: pr.Cell(occupied, 0.1, origin_m=[0, 0, float("inf")]), "origin_m = .*: must be x, y, z"),
            (lambda: pr.Cell([[[True], [True, False]]], 0.1), "occupied: must be an array of numbers, with rows"),
            (lambda: pr.Cell(occupied, 0.1, people=[people, people[:1]]), r"person 1: has shape \(1, 17, 13\)"),
            (lambda: pr.Cell(occupied, 0.1, people=[[True]]), r"person 0: has shape \(1, 1\)"),
            (lambda: study.sweep("cpu", threads=0), "^threads = 0: must be from 1 to 1024"),
            (lambda: study.sweep("cpu", threads=-3), "^threads = -3: must be from 1 to 1024"),
            (lambda: study.sweep("cpu", adapter="software"), 'adapter belongs to backend="gpu"'),
            (lambda: study.labels("lidar:posts/upright", snapshot=-1), "snapshot = -1: must be a whole number"),
            (lambda: study.labels("lidar:posts/upright", repeat=0.5), "repeat = 0.5: must be a whole number"),
            (lambda: study.each_labels(5), "poses = 5: must be a name or a list"),
            (lambda: pr.score_map(people, study, snapshot=-2, origin_m=[0, 0, 0], voxel_size_m=0.1), "snapshot = -2"),
            (lambda: pr.score_map("a.bt", study, pose="here"), "pose: must be an array of numbers"),
            (lambda: pr.score_map(people, study, sensor_m=np.zeros(3)), "sensor_m: belongs to files and points, and this is an array of labels"),
            (lambda: pr.score_map("a.bt", study, sensor_m=np.zeros(2)), r"sensor_m = \[0.0, 0.0\]: must be x, y, z"),
            (lambda: study.choose(at_most=None), "choose.at_most = None: leave the key out"),
            (lambda: best("nowhere"), "nowhere: has no choose.json"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                job()

    def test_no_line_of_a_file_is_told_where_there_is_none(self):
        keys, cell = test_labels.Cells.KEYS, pr.Cell(test_labels.Cells.random(1)[0], 0.1)
        camera = keys["sensor"][0]
        study = pr.Study.load(TINY)
        for job, message in [
            (lambda: pr.Study({**keys, "sed": 1}, scenes={"a": cell}), "sed"),
            (lambda: pr.Study({**keys, "seed": "x"}, scenes={"a": cell}), "seed"),
            (lambda: pr.Study({**keys, "sensor": [{**camera, "fov": 1}]}, scenes={"a": cell}), "fov"),
            (lambda: pr.Study({**keys, "sensor": [{**camera, "fov_deg": "x"}]}, scenes={"a": cell}), "sensor.*fov_deg"),
            (lambda: pr.Study(keys, scenes={"a": {"object": [{"name": "box", "colour": "red"}]}}), "colour"),
            (lambda: pr.Study(keys, scenes={"a": {"object": [{"name": "box", "role": "x"}]}}), "object.*role"),
            (lambda: study.choose(objective="f1", region="robot", at_mots=1), "at_mots"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, f"(?s){message}") as told:
                job()
            self.assertNotRegex(str(told.exception), r"\bline \d|\| ")

    def test_empty_lists_and_arrays_are_nothing(self):
        occupied, people = test_labels.Cells.random(1)
        study = pr.Study.load(TINY)
        for nobody in [None, [], (), np.empty((0, *people.shape), bool)]:
            cell = pr.Cell(occupied, 0.1, people=nobody)
            self.assertEqual([name for name, *_ in cell._parts], ["environment"])
        for both in [[people, people], (people, people), np.array([people, people])]:
            cell = pr.Cell(occupied, 0.1, people=both)
            self.assertEqual([name for name, *_ in cell._parts], ["person 0", "person 1", "environment"])
        self.assertEqual(list(study.each_labels([], combination="lidar")), [])
        self.assertEqual(list(study.each_labels(np.array([], str), combination="lidar")), [])
        [one] = study.each_labels("lidar:posts/upright", backend="cpu")
        self.assertEqual(one.poses, "lidar:posts/upright")

    def test_labels_are_equal_if_all_of_them_is(self):
        study = pr.Study.load(TINY)
        one, same = [study.labels("lidar:posts/upright", backend=backend) for backend in ("cpu", "oracle")]
        other = study.labels("lidar:posts/corner", backend="cpu")
        self.assertTrue(one == same and one != other and not one == other)
        self.assertNotEqual(one, one.labels)
        self.assertIn(one, [other, same])

    def test_a_missing_extra_is_named(self):
        study = pr.Study.load(TINY)
        result = study.sweep("cpu", progress=False)
        with tempfile.TemporaryDirectory() as out:
            best = study.choose(out, backend="cpu", progress=False, objective="f1", region="robot", at_most=1)
            for module, job in [
                ("pandas", result.to_pandas),
                ("pyarrow", result.to_arrow),
                ("xarray", lambda: result.to_xarray("lidar")),
                ("pandas", best.front),
                ("pandas", lambda: study.judge(best)),
            ]:
                kept = sys.modules.get(module)
                sys.modules[module] = None
                try:
                    with self.assertRaisesRegex(ModuleNotFoundError, rf"{module}, .*pip install 'perirobot\[tables\]'"):
                        job()
                finally:
                    sys.modules.pop(module)
                    if kept is not None:
                        sys.modules[module] = kept

    def test_types_name_what_is_possible(self):
        hints = typing.get_type_hints(pr.Study.evaluate, {**vars(pr), **vars(sys.modules["perirobot.scoring"])})
        self.assertEqual(typing.get_args(hints["backend"]), ("auto", "cpu", "gpu", "oracle"))
        self.assertEqual(typing.get_args(hints["frame"]), ("link", "optical"))


class Warned(unittest.TestCase):
    def caught(self, study: pr.Study) -> list[warnings.WarningMessage]:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            study.sweep("cpu", progress=False)
        return caught

    def test_many_cells_give_one_warning(self):
        cells = {}
        for number in range(300):
            occupied, people = test_labels.Cells.random(number, (12, 10, 13))
            people[:] = False
            people[4, 4 : 5 + number % 3, :2] = True
            cells[f"cell {number}"] = pr.Cell(occupied, 0.1, people=people)
        region = {"name": "table", "box": {"min_m": [0, 0, 0], "max_m": [3, 3, 3]}}
        study = pr.Study({**test_labels.Cells.KEYS, "region": [region]}, scenes=cells)
        [warning] = self.caught(study)
        text = str(warning.message)
        self.assertLess(text.count("\n"), 7, text)
        self.assertRegex(text, r'cell 0: region "table": .* \(and 299 more scenes\)')
        self.assertRegex(text, r"study\.warnings lists all of them$")
        self.assertGreaterEqual(len(study.warnings), 300)
        self.assertTrue(all(line.startswith("cell ") for line in study.warnings))

    def test_warnings_have_a_class_and_point_at_the_caller(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        file = tiny_with_a_crumb(folder.name)
        for job in [
            lambda study: study.sweep("cpu", progress=False),
            lambda study: study.labels("lidar:posts/upright", backend="cpu"),
            lambda study: next(study.each_labels(combination="lidar", backend="cpu")),
            lambda study: study.evaluate(study.poses("lidar")[1], "lidar", backend="cpu"),
        ]:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                job(pr.Study.load(file))
            [warning] = caught
            self.assertIs(warning.category, pr.InputWarning)
            self.assertEqual((warning.filename, warning.lineno), (__file__, job.__code__.co_firstlineno))
        with self.assertWarnsRegex(pr.DeviceWarning, "lost") as warning:
            perirobot.warned.of_device("the device is lost")
        self.assertEqual(warning.filename, __file__)
        self.assertTrue(issubclass(pr.InputWarning, UserWarning) and issubclass(pr.DeviceWarning, UserWarning))

    def test_drivers_write_nothing_about_the_environment(self):
        code = f"""
import os, warnings
warnings.simplefilter("ignore")
import perirobot as pr
study = pr.Study.load({str(TINY)!r})
for _ in range(3):
    study.sweep("gpu", adapter="software", progress=False)
study.sweep("auto", progress=False)
assert "XDG_RUNTIME_DIR" not in os.environ
"""
        environment = {name: value for name, value in os.environ.items() if name != "XDG_RUNTIME_DIR"}
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))


class Shown(unittest.TestCase):
    def test_notebooks_show_tables(self):
        study = pr.Study.load(TINY)
        result = study.sweep("cpu", progress=False)
        html = result._repr_html_()
        self.assertEqual(html.count("<tr>"), 11)
        for name in result.columns:
            self.assertIn(f"<th>{name}</th>", html)
        self.assertIn("camera, lidar", study._repr_html_())
        self.assertIn("tiny.toml", repr(study))
        cell = pr.Cell(test_labels.Cells.random(1)[0], 0.1)
        keys = {**test_labels.Cells.KEYS, "region": [{**test_labels.Cells.KEYS["region"][0], "name": "<b>"}]}
        named = pr.Study(keys, scenes={"a": cell})
        self.assertIn("&lt;b&gt;", named._repr_html_())
        with tempfile.TemporaryDirectory() as out:
            best = study.choose(out, backend="cpu", progress=False, objective="f1", region="robot", at_most=1)
            self.assertIn("<th>at_most</th>", best._repr_html_())

    def test_the_version_is_that_of_the_program(self):
        manifest = (ROOT / "Cargo.toml").read_text()
        self.assertIn(f'version = "{pr.__version__}"', manifest)
        self.assertIn("__version__", pr.__all__)
        self.assertTrue(pathlib.Path(pr.__file__).with_name("py.typed").exists())


if __name__ == "__main__":
    unittest.main()
