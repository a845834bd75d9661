"""Arrays in the keys of a recorded sensor are the files that would be named."""

import os
import pathlib
import shutil
import tempfile
import unittest

import numpy as np

import perirobot as pr

GRID = {"voxel_size_m": 0.1, "bounds_m": {"min": [0.05, 0.05, 0.05], "max": [3.95, 2.95, 2.45]}}
REGION = {"name": "all", "box": {"min_m": [0, 0, 0], "max_m": [4, 3, 2.5]}}
CAMERA = {"name": "camera", "kind": "rgbd", "fov_deg": [87, 58], "resolution_px": [48, 32], "range_m": [0.1, 6]}
CAMERA["poses"] = [{"name": "spot", "list": [{"position_m": [2, 0.2, 2.2], "facing": [0, 1, -0.6]}]}]
BOX = {"object": [{"name": "box", "box": {"size_m": [0.5, 0.5, 1]}, "position_m": [2, 1.5, 0.5]}]}
POSE = [0.2, 1.4, 1.3, *(np.array([0.9, 0.1, -0.2, 0.3]) / np.linalg.norm([0.9, 0.1, -0.2, 0.3]))]


def depth_image() -> np.ndarray:
    """Depths with pixels that did not return."""
    random = np.random.default_rng(4)
    depth = random.uniform(0.5, 3, (12, 16))
    depth[0, :3] = 0, np.nan, np.inf
    return depth


def projected(depth: np.ndarray, fx: float, fy: float, cx: float, cy: float) -> list[list[float]]:
    """The points of a depth image in the optical frame, pixel by pixel."""
    points = []
    for v, row in enumerate(depth):
        for u, z in enumerate(row):
            if 0 < z < np.inf:
                points.append([float((u - cx) / fx * z), float((v - cy) / fy * z), float(z)])
    return points


class Recordings(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def study(self, *recordings: dict, scenes: dict | None = None) -> pr.Study:
        recorded = {"name": "mounted", "kind": "recorded", "recording": list(recordings)}
        keys = {"grid": GRID, "region": [REGION], "sensor": [CAMERA, recorded]}
        keys["combination"] = [{"name": "both", "sensors": ["camera", "mounted"]}, {"name": "alone", "sensors": ["mounted"]}]
        return pr.Study(keys, scenes=scenes or {"cell": BOX}, folder=self.folder)

    def same(self, one: pr.Study, other: pr.Study) -> np.ndarray:
        """The labels of the recording alone, if both studies agree in them and in those of both sensors."""
        for combination in ("both", "alone"):
            [ours] = one.each_labels(combination=combination, backend="cpu", progress=False)
            [theirs] = other.each_labels(combination=combination, backend="cpu", progress=False)
            self.assertEqual(ours, theirs)
        self.assertGreater((ours.labels != pr.UNKNOWN).sum(), 50)
        return ours.labels

    def ply(self, name: str, points: list[list[float]]) -> str:
        head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n"
        head += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
        text = "\n".join(" ".join(map(repr, point)) for point in points)
        (self.folder / name).write_text(f"{head}{text}\n")
        return name

    def keys_of_pose(self, pose: list[float]) -> dict:
        return {"position_m": pose[:3], "quaternion": dict(zip("wxyz", pose[3:]))}

    def test_clouds(self):
        random = np.random.default_rng(1)
        cloud = random.uniform([0.5, -0.8, -1], [3, 0.8, 0.5], (300, 3))
        file = self.ply("scan.ply", cloud.tolist())
        expected = self.study({"file": file, **self.keys_of_pose(POSE)})
        labels = self.same(self.study({"cloud": cloud, "pose": POSE}), expected)
        self.same(self.study({"cloud": cloud, **self.keys_of_pose(POSE)}), expected)
        # An organised cloud has NaN where nothing returned.
        organised = np.full((31, 10, 3), np.nan)
        organised[1:] = cloud.reshape(30, 10, 3)
        self.same(self.study({"cloud": organised, "pose": np.array(POSE)}), expected)
        level = self.study({"file": file, "position_m": POSE[:3], "yaw_deg": 30, "sensor_m": [0.1, 0, 0]})
        turned = self.same(self.study({"cloud": cloud, "pose": [*POSE[:3], 30], "sensor_m": (0.1, 0, 0)}), level)
        self.assertFalse(np.array_equal(labels, turned))
        # As many digits as the numbers have.
        single = cloud.astype(np.float32)
        file = self.ply("single.ply", single.astype(float).tolist())
        self.same(self.study({"cloud": single, "pose": POSE}), self.study({"file": file, **self.keys_of_pose(POSE)}))

    def test_depth_images(self):
        depth, intrinsics = depth_image(), (11.0, 12.0, 7.5, 5.25)
        points = projected(depth, *intrinsics)
        self.assertEqual(len(points), 12 * 16 - 3)
        np.testing.assert_array_equal(pr.depth_points(depth, intrinsics, frame="optical"), points)
        link = [[z, -x, -y] for x, y, z in points]
        np.testing.assert_array_equal(pr.depth_points(depth, intrinsics), link)
        expected = self.study({"file": self.ply("link.ply", link), **self.keys_of_pose(POSE)})
        labels = self.same(self.study({"depth": depth, "intrinsics": intrinsics, "pose": POSE}), expected)
        given = {"depth": depth, "intrinsics": np.array(intrinsics), "frame": "optical", "pose": POSE}
        optical = self.study({"file": self.ply("optical.ply", points), **self.keys_of_pose(POSE)})
        other = self.same(self.study(given), optical)
        self.assertFalse(np.array_equal(labels, other))
        # A camera that looks at a point has its middle pixel there.
        pose = pr.look_at([0.5, 1.5, 1.5], [2.0, 1.5, 0.5])
        middle = np.zeros((3, 3))
        middle[1, 1] = np.hypot(1.5, 1.0)
        study = self.study({"depth": middle, "intrinsics": (2, 2, 1, 1), "pose": pose})
        [view] = study.each_labels(combination="alone", backend="cpu", progress=False)
        [[x, y, z]] = np.argwhere(view.labels == pr.OCCUPIED)
        self.assertLess(np.abs(view.origin_m + 0.1 * (np.array([x, y, z]) + 0.5) - [2.0, 1.5, 0.5]).max(), 0.11)

    def test_labels(self):
        # Noise marks voxels that no return comes from, some of them occupied.
        noisy = {**CAMERA, "noise": {"std_m": 0.15}}
        own = pr.Study({"grid": GRID, "region": [REGION], "sensor": [noisy]}, scenes={"cell": BOX})
        view = own.labels("camera:spot/0")
        np.savez(
            self.folder / "map.npz",
            labels=view.labels.view(np.int8),
            origin_m=view.origin_m,
            voxel_size_m=view.voxel_size_m,
            hits=view.hits,
        )
        labels = self.same(self.study({"labels": view}), self.study({"file": "map.npz"}))
        np.testing.assert_array_equal(labels, view.labels)
        known = view.labels == pr.OCCUPIED
        np.savez(self.folder / "known.npz", labels=known.astype(np.int8), origin_m=[0.1, 0, 0], voxel_size_m=0.2)
        given = {"labels": known, "origin_m": [0.1, 0, 0], "voxel_size_m": 0.2, "pose": [4, 0.1, 0, 90]}
        expected = self.study({"file": "known.npz", "position_m": [4, 0.1, 0], "yaw_deg": 90})
        [ours], [theirs] = ([*one.each_labels(combination="alone", progress=False)] for one in (self.study(given), expected))
        self.assertEqual(ours, theirs)

    def test_several_moments_other_scenes_and_files(self):
        clouds = [np.random.default_rng(n).uniform([1, 1, 0], [3, 2, 2], (50, 3)) for n in range(2)]
        scenes = {"a": BOX, "b": BOX}
        named = [{"cloud": cloud, "scene": scene, "sensor_m": [0.5, 0.5, 2]} for cloud, scene in zip(clouds, "ab")]
        study = self.study(*named, scenes=scenes)
        one, other = study.each_labels(combination="alone", backend="cpu", progress=False)
        self.assertFalse(np.array_equal(one.labels, other.labels))
        moved = study.with_scenes({"a": BOX, "b": {"object": [{**BOX["object"][0], "position_m": [1, 1, 0.5]}]}})
        again = list(moved.each_labels(combination="alone", backend="cpu", progress=False))
        np.testing.assert_array_equal(again[1].labels, other.labels)
        # A saved study has the clouds as files.
        saved = pr.Study.load(study.save(self.folder / "saved"))
        for ours, theirs in zip((one, other), saved.each_labels(combination="alone", backend="cpu", progress=False)):
            self.assertEqual(ours, theirs)
        self.assertEqual(len(list((self.folder / "saved").rglob("*.pcd"))), 2)

    def test_a_cloud_is_scored_as_its_file(self):
        cloud = pr.depth_points(depth_image(), (11.0, 12.0, 7.5, 5.25))
        path = self.folder / self.ply("scan.ply", cloud.tolist())
        truth = self.study({"cloud": cloud, "pose": POSE})
        for words in ({}, {"sensor_m": [0.1, 0, 0.1]}):
            ours, theirs = (pr.score_map(given, truth, pose=POSE, **words) for given in (cloud, path))
            np.testing.assert_array_equal(ours.columns["tp"], theirs.columns["tp"])
            np.testing.assert_array_equal(ours.columns["uf"], theirs.columns["uf"])
            self.assertEqual(ours.reasons().to_dict(), theirs.reasons().to_dict())
        with self.assertRaisesRegex(ValueError, "origin_m, voxel_size_m: belong to labels"):
            pr.score_map(cloud, truth, voxel_size_m=0.1)
        with self.assertRaisesRegex(ValueError, "topic, message: belong to files"):
            pr.score_map(cloud, truth, topic="/points")
        with self.assertRaisesRegex(ValueError, r"recorded: has shape \(3,\), must be \(n, 3\)"):
            pr.score_map(np.zeros(3), truth)

    def test_what_is_wrong_is_named(self):
        cloud, depth = np.ones((5, 3)), depth_image()
        camera = {"depth": depth, "intrinsics": (9, 9, 7, 5)}
        for recording, message in [
            ({"cloud": cloud[:, :2]}, r"keys.sensor\[1\].recording\[0\].cloud: has shape \(5, 2\), must be \(n, 3\)"),
            ({"cloud": cloud[:0]}, "has no point"),
            ({"cloud": cloud * np.nan}, "has no point"),
            ({"cloud": [[1, 2, 3], [4]]}, "must be an array of numbers"),
            ({"cloud": cloud, "file": "a.ply"}, r"recording\[0\]: has cloud and file: give one of them"),
            ({"cloud": cloud, **camera}, "has cloud and depth: give one of them"),
            ({"cloud": cloud, "pose": [1, 2, 3]}, r"pose: has shape \(3,\), must be x, y, z in metres and the yaw"),
            ({"cloud": cloud, "pose": POSE, "yaw_deg": 3}, "has pose, and position_m, yaw_deg or quaternion: give one"),
            ({"cloud": cloud, "pose": [0, 0, 0, 2, 0, 0, 0]}, "quaternion"),
            ({"cloud": cloud, "intrinsics": (1, 1, 1, 1)}, "intrinsics"),
            ({"depth": depth}, r"recording\[0\]: has no intrinsics: \(fx, fy, cx, cy\) in pixels"),
            ({**camera, "depth": depth[0]}, r"depth: has shape \(16,\), must be \(rows, columns\)"),
            ({**camera, "depth": np.full((4, 4), 1500, np.uint16)}, "is of uint16, must be metres as floats: .* by 0.001"),
            ({**camera, "depth": -np.ones((4, 4))}, "has depths below 0"),
            ({**camera, "intrinsics": (0, 9, 7, 5)}, "intrinsics = .*: must be fx, fy, cx, cy in pixels, fx and fy above 0"),
            ({**camera, "intrinsics": (9, 9)}, "must be fx, fy, cx, cy"),
            ({**camera, "frame": "world"}, "frame = 'world': must be \"link\""),
            ({"labels": np.zeros((2, 2, 2), np.uint8)}, "needs origin_m"),
            ({"labels": np.zeros((2, 2)), "origin_m": [0, 0, 0], "voxel_size_m": 1}, r"must be \(nx, ny, nz\) of int8"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                self.study(recording)


if __name__ == "__main__":
    unittest.main()
