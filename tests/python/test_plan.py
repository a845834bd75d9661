"""The planner from Python: its study is that of the page."""

import json
import pathlib
import shutil
import tempfile
import unittest
import urllib.request

import perirobot as pr
from shared import ROOT


class Plans(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.cell = pathlib.Path(folder.name) / "cell"
        shutil.copytree(pathlib.Path(ROOT) / "scenes" / "tutorial", self.cell)
        self.path = self.cell / "study.toml"

    def ask(self, planner: pr.Planner, path: str, body: object = None) -> bytes:
        base, _, token = planner.url.partition("#")
        sent = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(f"{base}{path}", sent, {"X-Perirobot-Token": token})
        with urllib.request.urlopen(request) as answer:
            return bytes(answer.read())

    def place(self, planner: pr.Planner, sensor: str, pose: str) -> None:
        self.ask(planner, "edit", {"edit": "place", "sensor": sensor, "pose": pose})

    def test_the_study_is_that_of_the_page(self) -> None:
        study = pr.Study.load(self.path)
        [pose, *_], _ = study.poses("camera")
        with pr.plan(self.path, open_browser=False) as planner:
            self.assertNotIn("planned", planner.study().combinations)
            self.place(planner, "camera", pose)
            self.assertTrue(planner.is_changed())
            edited = planner.study()
            self.assertIn(planner.url, planner._repr_html_())
        self.assertIn("planned", edited.combinations)
        self.assertNotIn('name = "planned"', self.path.read_text(), "it was not saved")
        planned = edited.sweep("cpu").to_pandas().query("combination == 'planned'")
        alone = study.sweep("cpu").to_pandas()
        alone = alone[(alone.poses == planned.poses.iloc[0])]
        for column in ("tp", "fp", "fn", "tn", "uo", "uf"):
            self.assertEqual(sorted(planned[column]), sorted(alone[column]), column)
        with self.assertRaises(RuntimeError):
            planner.study()

    def test_scenes_are_those_of_the_page(self) -> None:
        scene = self.cell / "cell.toml"
        before = scene.read_text()
        study = pr.Study.load(self.path, voxel_size_m=0.2)
        with pr.plan(study, open_browser=False) as planner:
            state = json.loads(self.ask(planner, "state"))
            file = state["scene_files"][0]
            one = next(one for one in file["objects"] if one["name"] == "gearbox")
            [x, y, z] = one["positions_m"][0]
            edit = {"edit": "move_object", "file": file["name"], "object": one["name"], "position_m": [x + 0.5, y, z]}
            self.ask(planner, "edit", edit)
            moved = planner.study()
        self.assertEqual(scene.read_text(), before, "it was not saved")
        tables = [one.sweep("cpu").to_pandas() for one in (study, moved)]
        self.assertFalse(tables[0].tp.equals(tables[1].tp))

    def test_what_is_wrong_is_a_value_error(self) -> None:
        with self.assertRaisesRegex(ValueError, "nowhere.toml"):
            pr.plan(self.cell / "nowhere.toml", open_browser=False)
        with pr.plan(self.path, open_browser=False):
            with self.assertRaisesRegex(ValueError, "another planner"):
                pr.plan(self.path, open_browser=False)
            with pr.plan(pr.Study.load(self.path), open_browser=False, read_only=True) as reader:
                self.assertFalse(reader.is_changed())
