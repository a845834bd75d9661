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

    def place(self, planner: pr.Planner, sensor: str, pose: str) -> None:
        base, _, token = planner.url.partition("#")
        body = json.dumps({"edit": "place", "sensor": sensor, "pose": pose}).encode()
        request = urllib.request.Request(f"{base}edit", body, {"X-Perirobot-Token": token})
        urllib.request.urlopen(request).close()

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

    def test_what_is_wrong_is_a_value_error(self) -> None:
        with self.assertRaisesRegex(ValueError, "nowhere.toml"):
            pr.plan(self.cell / "nowhere.toml", open_browser=False)
        with pr.plan(self.path, open_browser=False):
            with self.assertRaisesRegex(ValueError, "another planner"):
                pr.plan(self.path, open_browser=False)
            with pr.plan(pr.Study.load(self.path), open_browser=False, read_only=True) as reader:
                self.assertFalse(reader.is_changed())
