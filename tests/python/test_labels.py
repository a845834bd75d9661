"""Labels from Python are those that the command line exports, and counted against the truth they are the sweep's counts."""

import shutil
import tempfile
import tomllib
import unittest
import warnings

import numpy as np
import pandas as pd
import polars

import perirobot as pr
from shared import ROOT, program

BACKENDS = [("cpu", None), ("oracle", None), ("gpu", "software")]


class SameVoxels(unittest.TestCase):
    def test_labels_are_those_of_export(self):
        study = pr.Study.load(ROOT / "scenes/sensors.toml")
        swept = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, swept)
        self.assertEqual(program("sweep", "scenes/sensors.toml", "--out", swept).returncode, 0)
        for combination in study.combinations:
            rows = {labels.poses: labels for labels in study.each_labels(combination=combination)}
            poses = list(rows)[-1]
            last = study.scenes[-1]
            with tempfile.TemporaryDirectory() as out:
                choice = ["--pose", poses, "--combination", combination, "--scene", last]
                done = program("export", swept, *choice, "--out", out, "--backend", "cpu")
                self.assertEqual(done.returncode, 0, done.stderr)
                with np.load(f"{out}/view.npz") as view:
                    for backend, adapter in BACKENDS:
                        with self.subTest(combination=combination, backend=backend):
                            named = {"combination": combination, "scene": last}
                            labels = study.labels(poses, **named, backend=backend, adapter=adapter)
                            self.assertEqual(labels.labels.dtype, np.uint8)
                            np.testing.assert_array_equal(labels.labels.view(np.int8), view["labels"])
                            np.testing.assert_array_equal(labels.origin_m, view["origin_m"])
                            self.assertEqual(labels.voxel_size_m, view["voxel_size_m"])
                            self.assertEqual(labels.poses, view["poses"])

    def test_the_iterator_has_each_moment_and_choice_once_and_in_order(self):
        study = pr.Study.load(ROOT / "scenes/sensors.toml")
        frame = study.sweep("cpu", progress=False).to_pandas()
        for combination in study.combinations:
            rows = frame[frame.combination == combination]
            rows = rows.drop_duplicates(["scene", "snapshot", "repeat", "poses"])
            expected = list(rows[["scene", "snapshot", "repeat", "poses"]].itertuples(index=False, name=None))
            seen = [(l.scene, l.snapshot, l.repeat, l.poses) for l in study.each_labels(combination=combination)]
            self.assertEqual(seen, expected)

    def test_some_poses_and_scenes(self):
        study = pr.Study.load(ROOT / "scenes/quick.toml", voxel_size_m=0.2)
        poses = ["camera:right-wall/8/1", "camera:right-wall/4/1"]
        seen = list(study.each_labels(poses, scenes=study.scenes[:1]))
        self.assertEqual([labels.poses for labels in seen], poses)
        for labels in seen:
            np.testing.assert_array_equal(labels.labels, study.labels(labels.poses).labels)

    def test_names_that_are_wrong_are_refused(self):
        study = pr.Study.load(ROOT / "scenes/quick.toml", voxel_size_m=0.2)
        with self.assertRaisesRegex(ValueError, "did you mean camera:right-wall/8/1"):
            study.labels("camera:right-wal/8/1")
        with self.assertRaisesRegex(ValueError, "^scene nowhere: "):
            study.labels("camera:right-wall/8/1", scene="nowhere")
        with self.assertRaisesRegex(ValueError, "scenes: 'nowhere' must be one of"):
            study.each_labels(["camera:right-wall/8/1"], scenes=["nowhere"])


class Cells(unittest.TestCase):
    KEYS = {
        "region": [{"name": "all", "box": {"min_m": [0, 0, 0], "max_m": [2.1, 1.7, 1.3]}}],
        "sensor": [
            {
                "name": "camera",
                "kind": "rgbd",
                "fov_deg": [70, 50],
                "resolution_px": [64, 48],
                "range_m": [0.1, 8],
                "poses": [
                    {"name": "wall", "list": [{"position_m": [0.15, 0.15, 0.95], "facing": [1, 1, -0.4]}]}
                ],
            }
        ],
    }

    @staticmethod
    def random(seed: int, shape=(21, 17, 13)) -> tuple[np.ndarray, np.ndarray]:
        draws = np.random.default_rng(seed).random(shape)
        occupied = draws < 0.01
        occupied[:3, :3, -4:] = False
        people = np.zeros(shape, bool)
        people[12:14, 9:11, 1:9] = True
        return occupied, people

    def study(self, number: int) -> pr.Study:
        cells = {}
        for seed in range(number):
            occupied, people = self.random(seed)
            cells[f"cell {seed}"] = pr.Cell(occupied, 0.1, people=people)
        return pr.Study(self.KEYS, scenes=cells)

    def test_counts_are_labels_against_the_arrays(self):
        study = self.study(3)
        frame = study.sweep("cpu", progress=False).to_pandas()
        self.assertEqual(study.voxel_size_m, 0.1)
        for labels in study.each_labels():
            occupied, people = self.random(int(labels.scene.split()[1]))
            truth = occupied | people
            self.assertEqual(labels.labels.shape, truth.shape)
            row = frame[(frame.scene == labels.scene) & (frame.representation == labels.representation)].iloc[0]
            for name, label, there in [
                ("tp", pr.OCCUPIED, truth),
                ("fp", pr.OCCUPIED, ~truth),
                ("fn", pr.FREE, truth),
                ("tn", pr.FREE, ~truth),
                ("uo", pr.UNKNOWN, truth),
                ("uf", pr.UNKNOWN, ~truth),
                ("tp_human", pr.OCCUPIED, people),
            ]:
                self.assertEqual(row[name], ((labels.labels == label) & there).sum(), name)
            self.assertGreater(row.tp, 0)

    def test_any_memory_layout_is_the_same_cell(self):
        occupied, people = self.random(5)
        told = []
        for layout in [np.ascontiguousarray, np.asfortranarray, lambda a: np.flip(np.flip(a, 1).copy(), 1)]:
            cell = pr.Cell(layout(occupied), 0.1, people=[layout(people)])
            told.append(pr.Study(self.KEYS, scenes={"a": cell}).labels("camera:wall/0").labels)
        np.testing.assert_array_equal(told[0], told[1])
        np.testing.assert_array_equal(told[0], told[2])

    def test_people_may_be_among_what_is_occupied(self):
        occupied, people = self.random(1)
        told = []
        for voxels in [occupied & ~people, occupied | people]:
            study = pr.Study(self.KEYS, scenes={"a": pr.Cell(voxels, 0.1, people=people)})
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", pr.InputWarning)
                told.append(study.sweep("cpu", progress=False).to_pandas())
            # People inside of something would be listed, too.
            self.assertEqual([w for w in study.warnings if "people are 1.2 to 2.2 m tall" not in w], [])
        pd.testing.assert_frame_equal(*told, check_exact=True)

    def test_cells_elsewhere_keep_their_corner(self):
        occupied, people = self.random(1)
        cell = pr.Cell(occupied, 0.1, people=people, origin_m=[-0.3, 0, 0])
        labels = pr.Study(self.KEYS, scenes={"a": cell}).labels("camera:wall/0")
        np.testing.assert_allclose(labels.origin_m, [-0.3, 0, 0])

    def test_keys_and_arrays_that_are_wrong_are_refused(self):
        occupied, people = self.random(1)
        with self.assertRaisesRegex(ValueError, r"occupied: has shape \(2, 2\)"):
            pr.Cell(np.ones((2, 2), bool), 0.1)
        with self.assertRaisesRegex(ValueError, "occupied: is of float64, must be bool"):
            pr.Cell(np.ones((2, 2, 2)), 0.1)
        with self.assertRaisesRegex(ValueError, r"person 0: has shape \(1, 2, 3\), must be \(21, 17, 13\)"):
            pr.Cell(occupied, 0.1, people=np.ones((1, 2, 3), bool))
        with self.assertRaisesRegex(ValueError, "environment: no voxel is set"):
            pr.Cell(np.zeros((2, 2, 2), bool), 0.1)
        with self.assertRaisesRegex(ValueError, "origin_m = .* must be multiples of voxel_size_m"):
            pr.Cell(occupied, 0.1, origin_m=[0.05, 0, 0])
        cell = pr.Cell(occupied, 0.1)
        with self.assertRaisesRegex(ValueError, r"\(study\): .*fov_deg"):
            camera = {**self.KEYS["sensor"][0], "fov_deg": [70, 190]}
            pr.Study({**self.KEYS, "sensor": [camera]}, scenes={"a": cell})
        with self.assertRaisesRegex(ValueError, "must have one size"):
            pr.Study(self.KEYS, scenes={"a": cell, "b": pr.Cell(occupied, 0.2)})
        with self.assertRaisesRegex(ValueError, r"(?s)a\.toml: .*colour"):
            pr.Study(self.KEYS, scenes={"a": {"object": [{"name": "box", "colour": "red"}]}})


class Evaluate(unittest.TestCase):
    def test_listed_poses_have_the_counts_of_the_sweep(self):
        study = pr.Study.load(ROOT / "scenes/tiny.toml")
        frame = study.sweep("cpu", progress=False).to_pandas()
        for sensor in study.sensors:
            names, poses = study.poses(sensor)
            for backend, adapter in BACKENDS:
                counts = study.evaluate(poses, sensor, backend=backend, adapter=adapter)
                rows = frame[frame.combination == sensor]
                for number, name in enumerate(names):
                    told = rows[rows.poses == f"{sensor}:{name}"][list(pr.COUNTERS)].to_numpy()
                    # Rows go by scene, snapshot, repeat, representation and region, as the axes do.
                    np.testing.assert_array_equal(counts[number].reshape(told.shape), told)

    def test_several_sensors_have_the_counts_of_their_combination(self):
        told = {}
        for fusion in ["occupied_wins", "octomap"]:
            keys = tomllib.loads((ROOT / "scenes/tiny.toml").read_text())
            # Two that are right are the same by either rule: only noise, and many, tell the rules apart.
            lidar = next(sensor for sensor in keys["sensor"] if sensor["name"] == "lidar")
            lidar.update(noise={"std_m": 0.15}, dropout=0.1)
            listed = lidar["poses"][0]["list"]
            sensors = []
            for number in range(4):
                # Each stands elsewhere.
                turned = listed[number % 3 :] + listed[: number % 3]
                sensors.append({**lidar, "name": f"lidar {number}", "poses": [{"name": "posts", "list": turned}]})
            named = [sensor["name"] for sensor in sensors]
            keys["sensor"], keys["combination"] = sensors, [{"name": "all", "sensors": named, "fusion": fusion}]
            study = pr.Study(keys, folder=ROOT / "scenes")
            frame = study.sweep("cpu", progress=False).to_pandas()
            names, poses = {}, {}
            for sensor in named:
                names[sensor], poses[sensor] = study.poses(sensor)
            combined = [";".join(f"{sensor}:{names[sensor][row]}" for sensor in named) for row in range(3)]
            told[fusion] = np.array([frame[frame.poses == name][list(pr.COUNTERS)].to_numpy() for name in combined])
            for backend, adapter in BACKENDS:
                counts = study.evaluate(poses, backend=backend, adapter=adapter)
                np.testing.assert_array_equal(counts.reshape(told[fusion].shape), told[fusion])
        differs = (told["occupied_wins"] != told["octomap"]).any(axis=2)
        self.assertTrue(differs.all(), differs)
        with self.assertRaisesRegex(ValueError, 'sensor "lidar 1": has 1 poses, and the first sensor has 2'):
            study.evaluate({"lidar 0": poses["lidar 0"][:2], "lidar 1": poses["lidar 1"][:1]})
        with self.assertRaisesRegex(ValueError, "sensor: belongs to an array of poses"):
            study.evaluate({"lidar 0": poses["lidar 0"]}, "lidar 0")

    def noisy(self, *, equal: int = 0) -> pr.Study:
        """The tiny cell with a lidar whose returns are noisy and lost and whose mount is off, or also a pair of them."""
        keys = tomllib.loads((ROOT / "scenes/tiny.toml").read_text())
        lidar = next(sensor for sensor in keys["sensor"] if sensor["name"] == "lidar")
        lidar.update(noise={"std_m": 0.05}, dropout=0.1, calibration={"position_m": 0.02, "angle_deg": 1.0})
        keys.update(sensor=[lidar], repeats=2)
        if equal:
            equal_ones = {"name": "equal", "sensors": ["lidar"], "count": {"lidar": equal}}
            keys["combination"] = [{**equal_ones, "fusion": "octomap"}]
        return pr.Study(keys, folder=ROOT / "scenes")

    def test_noise_belongs_to_the_pose(self):
        study = self.noisy()
        listed = study.poses("lidar")[1]
        free = listed[:1] + [0.0123, 0, 0.02, 0, 0, 0, 0]
        poses = np.vstack([listed, free])
        expected = study.evaluate(poses, backend="cpu")
        self.assertFalse((expected[:, :, 0] == expected[:, :, 1]).all(), "there is no noise")
        for backend, adapter in BACKENDS:
            for order in [[3, 2, 1, 0], [3], [1, 3, 3, 0, 1]]:
                counts = study.evaluate(poses[order], backend=backend, adapter=adapter)
                np.testing.assert_array_equal(counts, expected[order])
        # A rotation is the same with all signs turned, and the listed poses have the noise of the sweep in any order.
        turned = poses[[2, 0]] * [1, 1, 1, -1, -1, -1, -1]
        np.testing.assert_array_equal(study.evaluate(turned, backend="cpu"), expected[[2, 0]])
        frame = study.sweep("cpu", progress=False).to_pandas()
        for number, name in enumerate(study.poses("lidar")[0]):
            told = frame[frame.poses == f"lidar:{name}"][list(pr.COUNTERS)].to_numpy()
            np.testing.assert_array_equal(expected[number].reshape(told.shape), told)

    def test_equal_sensors_are_counted_together(self):
        study = self.noisy(equal=2)
        names, poses = study.poses("lidar")
        frame = study.sweep("cpu", progress=False).to_pandas()
        pairs = [(0, 1), (0, 2), (1, 2)]
        together = np.array([poses[list(pair)] for pair in pairs])
        for backend, adapter in BACKENDS:
            counts = study.evaluate(together, backend=backend, adapter=adapter)
            for number, (one, other) in enumerate(pairs):
                told = frame[frame.poses == f"lidar:{names[one]};lidar:{names[other]}"][list(pr.COUNTERS)].to_numpy()
                np.testing.assert_array_equal(counts[number].reshape(told.shape), told)
            # Which of two equal sensors comes first is the same.
            swapped = study.evaluate({"lidar": together[:, ::-1]}, backend=backend, adapter=adapter)
            np.testing.assert_array_equal(swapped, counts)

    def test_a_pose_may_be_given_in_any_form(self):
        study = self.noisy()
        poses = study.poses("lidar")[1]
        expected = study.evaluate(poses, backend="cpu")
        matrices = np.tile(np.eye(4), (len(poses), 1, 1))
        for matrix, (*at, w, x, y, z) in zip(matrices, poses):
            matrix[:3, 3] = at
            matrix[:3, :3] = [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        # The optical frame is z forward, x right, y down: its axes in those of the link.
        optical = matrices.copy()
        optical[:, :3, :3] = matrices[:, :3, :3] @ [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
        table = pd.DataFrame(poses, columns=["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"])
        table.insert(0, "sensor", "lidar")
        shuffled = table[["qz", "qw", "z_m", "sensor", "y_m", "x_m", "qy", "qx"]]
        along_x = [*poses[0][:3], 0.5, -0.5, 0.5, -0.5]
        for given, frame, rows in [
            (poses.tolist(), "link", slice(None)),
            (matrices, "link", slice(None)),
            (optical, "optical", slice(None)),
            (shuffled, "link", slice(None)),
            (polars.from_pandas(shuffled), "link", slice(None)),
            (poses[1], "link", slice(1, 2)),
            (matrices[2], "link", slice(2, 3)),
            (np.empty((0, 7)), "link", slice(0)),
            ([], "link", slice(0)),
            (matrices[:0], "link", slice(0)),
        ]:
            counts = study.evaluate(given, frame=frame, backend="cpu")
            np.testing.assert_array_equal(counts, expected[rows])
        # Looking along x with the optical axis, as a quaternion.
        level = [*poses[0][:3], 1, 0, 0, 0]
        np.testing.assert_array_equal(
            study.evaluate(along_x, frame="optical", backend="cpu"), study.evaluate(level, backend="cpu")
        )

    def test_quaternions_in_the_other_order_are_warned_of(self):
        study = pr.Study.load(ROOT / "scenes/tiny.toml")
        at = study.poses("camera")[1][0, :3]
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            study.sweep("cpu", progress=False)
            for yaw_deg in range(-170, 180, 20):
                half = np.radians(yaw_deg) / 2
                first = [*at, np.cos(half), 0, 0, np.sin(half)]
                caught.clear()
                study.evaluate(first, "camera", backend="cpu")
                self.assertEqual(caught, [], yaw_deg)
                study.evaluate([*at, 0, 0, np.sin(half), np.cos(half)], "camera", backend="cpu")
                # At small angles it is upright either way.
                if abs(yaw_deg) > 10:
                    [warning] = caught
                    self.assertIs(warning.category, pr.InputWarning)
                    self.assertIn("read as x, y, z, w they are upright", str(warning.message))
                    self.assertEqual(warning.filename, __file__)

    def test_poses_that_are_wrong_are_refused(self):
        study = pr.Study.load(ROOT / "scenes/tiny.toml")
        good = study.poses("camera")[1][:1]
        table = pd.DataFrame(good, columns=["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"])
        matrix = np.eye(4)
        matrix[:3, 3] = good[0, :3]
        for poses, message in [
            (good[:, :6], r"has shape \(1, 6\), must be \(n, 7\)"),
            (good[0, 0], r"has shape \(\), must be"),
            (np.ones((2, 3)), r"has shape \(2, 3\), must be"),
            ([[1, 2], [3]], "poses: must be an array of numbers, with rows of one length"),
            ("here", "poses: must be an array of numbers"),
            (np.ones((2, 0, 7)), "with no sensor in it"),
            (good * [1, 1, 1, 0, 0, 0, 0], r"poses\[0\]: .*a quaternion w, x, y, z of length 1"),
            (good * [1, 1, 1, 3, 3, 3, 3], r"poses\[0\]: .*a quaternion w, x, y, z of length 1"),
            (np.vstack([good, good * [np.nan, 1, 1, 1, 1, 1, 1]]), r"poses\[1\]: .*must be finite"),
            (good + [99, 0, 0, 0, 0, 0, 0], r'pose 0 is at .* outside of the voxels of scene "tiny"'),
            (matrix * 2, r"poses\[0\]: .*must be a rotation"),
            (matrix[:, [1, 0, 2, 3]], r"poses\[0\]: .*right-handed"),
            (matrix.T, r"poses\[0\]: .*its last row must be 0, 0, 0, 1"),
            (table.rename(columns={"qw": "w"}), "poses: has no column 'qw': needs x_m, y_m, z_m, qw"),
            (table.assign(sensor="lidar"), "poses: has rows of sensor 'lidar': keep those of 'camera' only"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                study.evaluate(poses, "camera", backend="cpu")
        with self.assertRaisesRegex(ValueError, 'sensor = "camra": must be one that takes poses'):
            study.evaluate(good, "camra")
        with self.assertRaisesRegex(ValueError, "frame = 'world': must be \"link\""):
            study.evaluate(good, "camera", frame="world")

    def test_a_true_pose_outside_of_the_grid_is_refused(self):
        study = self.noisy()
        poses = study.poses("lidar")[1]
        beside = poses[:1].copy()
        beside[0, 0] = study.labels("lidar:posts/upright").origin_m[0] + 0.001
        # Half of all mounts are off to the outside.
        rows = np.vstack([beside + [0, step, 0, 0, 0, 0, 0] for step in np.linspace(0, 0.1, 11)])
        with self.assertRaisesRegex(ValueError, r"pose \d+ with its mount off is at"):
            study.evaluate(rows, backend="cpu")


if __name__ == "__main__":
    unittest.main()
