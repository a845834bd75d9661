"""Arrays in the keys of scenes are the tables that files would name."""

import csv
import pathlib
import shutil
import tempfile
import tomllib
import unittest

import numpy as np

import perirobot as pr
from shared import ROOT

NAN = float("nan")


def joints(path: pathlib.Path) -> np.ndarray:
    """The joints of a table that ships."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return np.array([[float(row[axis] or NAN) for axis in ("x_m", "y_m", "z_m")] for row in csv.DictReader(lines)])


class Arrays(unittest.TestCase):
    KEYS = {
        "grid": {"voxel_size_m": 0.1, "bounds_m": {"min": [-2, -2, 0.05], "max": [2, 2, 2.4]}},
        "region": [{"name": "all", "box": {"min_m": [-1.9, -1.9, 0], "max_m": [1.9, 1.9, 2.2]}}],
        "sensor": [
            {
                "name": "camera",
                "kind": "rgbd",
                "fov_deg": [87, 58],
                "resolution_px": [64, 48],
                "range_m": [0.1, 8],
                "poses": [{"name": "one", "list": [{"position_m": [-1.8, 0, 2.2], "facing": [1, 0, -0.4]}]}],
            }
        ],
    }

    def folder(self) -> pathlib.Path:
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        return pathlib.Path(folder)

    def counts(self, objects: list, folder: pathlib.Path | str = ".") -> np.ndarray:
        study = pr.Study(self.KEYS, scenes={"cell": {"object": objects}}, folder=folder)
        return study.evaluate(study.poses()[1], backend="cpu")

    def test_joints_of_people_are_the_table_of_a_file(self):
        folder = self.folder()
        own = joints(ROOT / "scenes/paper/scene1_operator.csv")
        self.assertEqual(own.shape, (17, 3))
        walk = own + np.linspace([0, 0, 0], [0.6, 0.3, 0], 4)[:, None]
        for number, moment in enumerate(walk):
            np.savetxt(folder / f"{number}.csv", moment, delimiter=",", fmt="%.17g")
        files = [f"{number}.csv" for number in range(4)]
        told = self.counts(
            [{"name": "walker", "mannequin": files[0], "snapshots": {"mannequin": files}}], folder
        )
        self.assertEqual(told.shape[1], 4)
        self.assertGreater(len({moment.tobytes() for moment in told[0]}), 1, "somebody walks")
        for objects in [
            [{"name": "walker", "mannequin": walk}],
            [{"name": "walker", "mannequin": walk[0], "snapshots": {"mannequin": walk}}],
            [{"name": "walker", "mannequin": walk[0], "snapshots": {"mannequin": list(walk)}}],
        ]:
            np.testing.assert_array_equal(self.counts(objects), told)
        still = self.counts([{"name": "walker", "mannequin": walk[2]}])
        np.testing.assert_array_equal(still[0, 0], told[0, 2])

    def test_a_saved_study_has_the_tables(self):
        own = joints(ROOT / "scenes/paper/scene1_operator.csv")
        own[[1, 2, 3, 4]] = NAN
        walk = np.stack([own, own + [0.3, 0, 0]])
        study = pr.Study(self.KEYS, scenes={"cell": {"object": [{"name": "walker", "mannequin": walk}]}})
        path = study.save(self.folder() / "saved")
        again = pr.Study.load(path)
        poses = study.poses()[1]
        np.testing.assert_array_equal(again.evaluate(poses, backend="cpu"), study.evaluate(poses, backend="cpu"))
        saved = joints(next(pathlib.Path(path).parent.rglob("*mannequin 1.csv")))
        np.testing.assert_array_equal(saved, walk[1])

    def test_joints_of_robots_over_time(self):
        folder = ROOT / "scenes"
        pan = np.array([-100.0, -70.0, -20.0])
        arm = {"name": "arm", "urdf": "paper/ur10.urdf", "position_m": [0, 0, 0.5]}
        arm["joints_deg"] = {"shoulder_lift_joint": -60, "elbow_joint": 80}
        listed = {"joints_deg": [{"shoulder_pan_joint": value} for value in pan]}
        expected = self.counts([{**arm, "snapshots": listed}], folder)
        self.assertEqual(expected.shape[1], 3)
        self.assertGreater(len({moment.tobytes() for moment in expected[0]}), 1, "it moves")
        arrays = {"joints_deg": {"shoulder_pan_joint": pan}}
        np.testing.assert_array_equal(self.counts([{**arm, "snapshots": arrays}], folder), expected)
        over_time = {"time_s": np.arange(3.0), "shoulder_pan_joint": pan}
        animation = {"animation": {"joints": over_time, "angles": "deg", "times_s": [0, 1, 2]}}
        np.testing.assert_array_equal(self.counts([{**arm, "snapshots": animation}], folder), expected)

    def test_scenes_are_replaced(self):
        random = np.random.default_rng(2)

        def cell(voxels: np.ndarray) -> dict[str, pr.Cell]:
            return {"cell": pr.Cell(voxels, 0.1, origin_m=(-2, -2, 0))}

        keys = {name: values for name, values in self.KEYS.items() if name != "grid"}
        study = None
        poses = None
        for _ in range(3):
            voxels = random.random((40, 40, 24)) < 0.01
            fresh = pr.Study(keys, scenes=cell(voxels))
            poses = fresh.poses()[1]
            study = pr.Study(keys, scenes=cell(voxels)) if study is None else study.with_scenes(cell(voxels))
            np.testing.assert_array_equal(study.evaluate(poses, backend="cpu"), fresh.evaluate(poses, backend="cpu"))
            np.testing.assert_array_equal(study.truth().occupied, fresh.truth().occupied)
        path = study.save(self.folder() / "saved")
        np.testing.assert_array_equal(pr.Study.load(path).truth().occupied, study.truth().occupied)
        with self.assertRaisesRegex(ValueError, "scenes: only those of a study made of objects"):
            pr.Study.load(path).with_scenes(cell(voxels))
        with self.assertRaisesRegex(ValueError, "cell.toml: cannot be the keys of a file"):
            study.with_scenes({"cell": 1})

    def test_arrays_that_are_wrong_are_refused(self):
        own = joints(ROOT / "scenes/paper/scene1_operator.csv")
        for entry, message in [
            ({"mannequin": own[:, :2]}, r"scenes\['cell'\]\.object\[0\]\.mannequin: has shape \(17, 2\), must be \(joints, 3\)"),
            ({"mannequin": own[:5]}, "has 5 joints"),
            ({"mannequin": own * np.inf}, "must be finite, or NaN"),
            ({"mannequin": own[None][:0]}, r"mannequin: has shape \(0, 17, 3\)"),
            (
                {"urdf": "a.urdf", "snapshots": {"joints_deg": {"a": np.zeros(2), "b": np.zeros(3)}}},
                r"joints_deg: has arrays of shapes \[\(2,\), \(3,\)\], must have one of shape \(moments,\)",
            ),
            (
                {"urdf": "a.urdf", "snapshots": {"animation": {"joints": {"a": np.zeros(2)}, "times_s": [0]}}},
                "animation.joints: has no time_s",
            ),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                self.counts([{"name": "one", **entry}])


if __name__ == "__main__":
    unittest.main()
