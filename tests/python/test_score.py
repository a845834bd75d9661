"""Recorded maps score from Python as on the command line, from files and from memory."""

import pathlib
import shutil
import tempfile
import unittest
import warnings

import numpy as np
import pandas as pd

import perirobot as pr
from shared import READ, ROOT, program

STUDY = ROOT / "scenes/tiny.toml"
LIDAR = "lidar:posts/upright"


class Scores(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.study = pr.Study.load(STUDY)
        swept, cls.files = cls.folder / "swept", cls.folder / "files"
        for words in [
            ["sweep", STUDY, "--out", swept],
            ["export", swept, "--pose", LIDAR, "--out", cls.files, "--backend", "cpu"],
        ]:
            done = program(*words)
            assert done.returncode == 0, done.stderr

    def told(self, map: str, *words: object) -> pd.DataFrame:
        """What the command line says of a file."""
        out = self.folder / "scored.csv"
        done = program("score", self.files / map, STUDY, "--out", out, *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return pd.read_csv(out, **READ)

    def scored(self, recorded: object, **keys: object) -> pd.DataFrame:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return pr.score_map(recorded, truth=self.study, **keys).to_pandas()

    def test_files_score_as_on_the_command_line(self):
        moved = {"pose": [0.1, 0, 0, 2]}, ["--at", "0.1,0,0,2"]
        seen_from = {"sensor_m": [0.1, 0.2, 1.5]}, ["--sensor", "0.1,0.2,1.5"]
        for map, ways in [
            ("labels.bt", [({}, []), moved]),
            ("view.npz", [({}, []), moved]),
            ("points-lidar.ply", [({}, []), moved, seen_from]),
            ("view.mcap", [({"topic": "/lidar/points", "message": 0}, ["--topic", "/lidar/points", "--message", "0"])]),
        ]:
            for keys, words in ways:
                with self.subTest(map, **keys):
                    told, scored = self.told(map, *words), self.scored(self.files / map, **keys)
                    pd.testing.assert_frame_equal(scored, told, check_exact=True)
                    self.assertGreater(scored.tp.sum(), 0)

    def test_one_region_is_one_row(self):
        all_rows = self.scored(self.files / "labels.bt")
        for region in self.study.regions:
            [row] = self.scored(str(self.files / "labels.bt"), region=region).itertuples(index=False)
            self.assertEqual(row, next(all_rows[all_rows.region == region].itertuples(index=False)))
        cube = pr.score_map(self.files / "labels.bt", self.study).to_xarray()
        self.assertEqual(cube["tp"].sel(region="robot").item(), all_rows.set_index("region").tp["robot"])

    def test_labels_in_memory_score_as_the_map_that_they_are(self):
        told = self.told("labels.bt")
        labels = self.study.labels(LIDAR, backend="cpu")
        pd.testing.assert_frame_equal(self.scored(labels), told, check_exact=True)
        array, place = labels.labels, {"origin_m": labels.origin_m, "voxel_size_m": labels.voxel_size_m}
        signed = np.ascontiguousarray(array).view(np.int8)
        for layout in [array, signed, np.flip(np.flip(array, 0).copy(), 0)]:
            pd.testing.assert_frame_equal(self.scored(layout, **place), told, check_exact=True)
        occupied = array == pr.OCCUPIED
        rows, known = self.scored(occupied, **place), self.scored(occupied.astype(np.uint8), **place)
        pd.testing.assert_frame_equal(rows, known, check_exact=True)
        self.assertEqual((rows.uo + rows.uf).sum(), 0)

    def test_reasons_add_up_to_what_is_not_called_occupied(self):
        for map, keys in [("labels.bt", {}), ("labels.bt", {"sensor_m": [-0.9, 0.6, 0.9]}), ("points-lidar.pcd", {})]:
            with self.subTest(map, **keys), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                scored = pr.score_map(self.files / map, self.study, **keys)
                rows, reasons = scored.to_pandas().set_index("region"), scored.reasons()
                missed = reasons.groupby("region").voxels_occupied.sum()
                pd.testing.assert_series_equal(missed, (rows.fn + rows.uo)[missed.index], check_names=False)
                self.assertEqual(missed.sum(), (rows.fn + rows.uo).sum())
                people = reasons[reasons.region == "human"].voxels_human.sum()
                self.assertEqual(people, rows.fn_human["human"] + rows.uo_human["human"])
                told = set(reasons.reason)
                self.assertEqual("hidden" in told, map != "labels.bt" or keys != {}, told)
                self.assertEqual(((reasons.object != "") == (reasons.reason == "hidden")).all(), True)
        [region] = set(pr.score_map(self.files / "labels.bt", self.study, region="human").reasons().region)
        self.assertEqual(region, "human")

    def test_a_quaternion_is_as_good_as_a_yaw(self):
        map = self.files / "labels.bt"
        for yaw_deg in [0, 30, 90, -120]:
            half = np.radians(yaw_deg) / 2
            turned = [0.2, 0.1, 0, np.cos(half), 0, 0, np.sin(half)]
            pd.testing.assert_frame_equal(
                self.scored(map, pose=turned), self.scored(map, pose=[0.2, 0.1, 0, yaw_deg]), check_exact=True
            )

    def test_a_cloud_may_be_tilted(self):
        points = np.random.default_rng(1).uniform([-0.4, -0.4, 0.3], [0.4, 0.4, 1.2], (50, 3))
        sensor = np.array([0.7, 0.6, 1.1])
        # The frame lies on its side: its y is the world's z.
        on_its_side = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
        rows = []
        for name, turn, pose in [
            ("upright", np.eye(3), [0, 0, 0, 0]),
            ("tilted", on_its_side, [0, 0, 0, 0.5**0.5, 0.5**0.5, 0, 0]),
        ]:
            cloud = self.folder / f"{name}.ply"
            heading = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n"
            axes = "".join(f"property double {axis}\n" for axis in "xyz")
            lines = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in (points @ turn).tolist())
            cloud.write_text(f"{heading}{axes}end_header\n{lines}")
            rows.append(self.scored(cloud, pose=pose, sensor_m=sensor @ turn))
        pd.testing.assert_frame_equal(*rows, check_exact=True)
        self.assertGreater(rows[0].tn.sum(), 0)

    def test_what_is_wrong_is_refused(self):
        map, array = self.files / "labels.bt", np.ones((2, 2, 2), np.uint8)
        place = {"origin_m": [0, 0, 0.5], "voxel_size_m": 0.1}
        for recorded, keys, message in [
            (self.files / "none.bt", {}, r"none\.bt"),
            (STUDY, {}, r"must be a \.bt, \.ot, \.npz, \.pcd, \.ply or \.mcap file"),
            (map, {"region": "hall"}, r'region = "hall": must be one of \["robot"'),
            (map, {"scene": "hall"}, "scene hall"),
            (map, {"snapshot": 3}, "snapshot 3: must be from 0 to 0"),
            (map, {"pose": [0, 0, 0]}, r"pose = \[0\.0, 0\.0, 0\.0\]: must be x, y, z in metres and the yaw"),
            (map, {"pose": [0, 0, 0, np.nan]}, "pose = .*: must be x, y, z"),
            (map, {"pose": [90, 0, 0, 0]}, "says nothing inside the grid"),
            (map, {"pose": [0, 0, 0, 0.5**0.5, 0.5**0.5, 0, 0]}, "turned about the vertical only"),
            (map, {"sensor_m": [0, 0]}, "sensor_m = .*: must be x, y, z"),
            (map, {"topic": "/points"}, "topic and message are asked of .mcap files only"),
            (map, place, "origin_m, voxel_size_m: belong to arrays"),
            (array, {}, "origin_m, voxel_size_m: say where"),
            (array, {**place, "sensor_m": [0, 0, 0]}, "sensor_m: belongs to files and points, and this is an array of labels"),
            (array[0], place, r"recorded: has shape \(2, 2\), must be \(nx, ny, nz\)"),
            (array * 1.0, place, "recorded: is of float64, must be int8, uint8 or bool"),
            (array * 7, place, r"recorded: labels: \[0, 0, 0\] = 7: must be 1 \(occupied\)"),
            (array * 255, place, "recorded: labels: has no voxel that is occupied or free"),
            (array, {**place, "voxel_size_m": 0}, "voxel_size_m = 0: must be a length above 0"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                self.scored(recorded, **keys)


if __name__ == "__main__":
    unittest.main()
