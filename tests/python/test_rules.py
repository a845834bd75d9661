"""Rules of cells as they are, counted by numpy from what is truly there: reflectance, curtains that latch, muting."""

import math
import tomllib
import unittest
import warnings

import numpy as np

import perirobot as pr
from shared import ROOT
from shared_rules import VOXEL_M, path, quantised

class Reflectance(unittest.TestCase):
    def labels_of(self, reflectance: dict[str, float], range_of) -> None:
        """Compares a scanner's labels with a plain march; `range_of` is how far it detects a person and a wall."""
        person = {"name": "person", "role": "human", "cylinder": {"radius_m": 0.25, "height_m": 1.7}}
        wall = {"name": "wall", "box": {"size_m": [0.3, 5.6, 1.8]}, "position_m": [6.05, 0.03, 0.93]}
        objects = [dict(wall), {**person, "position_m": [3.51, 0.42, 0.9]}]
        for thing in objects:
            if thing["name"] in reflectance:
                thing["reflectance"] = reflectance[thing["name"]]
        region = {"name": "all", "box": {"min_m": [-9, -9, -9], "max_m": [9, 9, 9]}}
        scanner = {
            "name": "scanner",
            "kind": "lidar",
            "rings_deg": [0],
            "fov_deg": 120,
            "resolution_deg": 1,
            "range_m": [0.1, 7.3],
            "reflectance_ranges_m": [[0.018, 2.5], [0.9, 7.0]],
            "poses": [{"name": "post", "list": [{"position_m": [0.52, 0.13, 1.04], "facing": [1, 0, 0]}]}],
        }
        bounds = {"min": [0, -3, 0], "max": [7, 3, 2]}
        keys = {"grid": {"voxel_size_m": VOXEL_M, "bounds_m": bounds}, "region": [region], "sensor": [scanner]}
        study = pr.Study(keys, scenes={"corridor": {"object": objects}})
        with warnings.catch_warnings():
            # Its region is larger than its grid, and its scanner hangs in the air.
            warnings.simplefilter("ignore", pr.InputWarning)
            truth, found = study.truth(), study.labels("post/0", backend="oracle")
        low = [round(edge / VOXEL_M) for edge in truth.origin_m]
        position = [0.52, 0.13, 1.04]
        origin = [quantised(at / VOXEL_M * 65536) - (corner << 16) for at, corner in zip(position, low)]
        expected = np.full(truth.occupied.shape, pr.UNKNOWN, np.uint8)
        hits = np.zeros(truth.occupied.shape, bool)
        ends = []
        limits = {whose: quantised(min(range_of(whose), 7.3) / VOXEL_M * 65536) for whose in ("person", "wall")}
        longest = quantised(7.3 / VOXEL_M * 65536)
        lost = 0
        for number in range(120):
            azimuth = math.radians(-60 + number)
            unit = [math.cos(azimuth), math.sin(azimuth), 0.0]
            direction = [2 * quantised(part * 32768) for part in unit]
            passed = [tuple(at >> 16 for at in origin)]
            for distance, voxel in path(origin, direction, truth.occupied.shape):
                if distance > longest:
                    break
                if truth.occupied[voxel]:
                    self.assertGreaterEqual(distance, quantised(0.1 / VOXEL_M * 65536))
                    whose = "person" if truth.human[voxel] else "wall"
                    if distance <= limits[whose]:
                        for at in passed:
                            expected[at] = pr.FREE
                        ends.append(voxel)
                        hits[voxel] = True
                    else:
                        lost += 1
                    break
                passed.append(voxel)
        for voxel in ends:
            expected[voxel] = pr.OCCUPIED
        np.testing.assert_array_equal(found.labels, expected)
        np.testing.assert_array_equal(found.hits, hits)
        for backend in ("cpu", "auto"):
            self.assertEqual(study.labels("post/0", backend=backend), found, backend)
        self.lost.append(lost)

    def test_a_plain_march_gives_the_same_labels(self):
        self.lost = []
        slope = math.log(7.0 / 2.5) / math.log(0.9 / 0.018)

        def between(share: float) -> float:
            return 2.5 * (share / 0.018) ** slope

        # People have 0.018 without a value, and a wall has no limit.
        self.labels_of({}, lambda whose: 2.5 if whose == "person" else math.inf)
        self.labels_of({"person": 0.05}, lambda whose: between(0.05) if whose == "person" else math.inf)
        self.labels_of({"person": 0.9, "wall": 0.4}, lambda whose: 7.0 if whose == "person" else between(0.4))
        self.labels_of({"person": 0.01}, lambda whose: 2.5 * math.sqrt(0.01 / 0.018) if whose == "person" else math.inf)
        self.assertEqual([lost > 0 for lost in self.lost], [True, False, True, True], self.lost)


class Curtains(unittest.TestCase):
    def test_a_latch_and_its_muting_are_what_numpy_makes_of_the_truth(self):
        keys = tomllib.loads((ROOT / "scenes/delivery.toml").read_text(encoding="utf-8"))
        keys["combination"] = [{"name": "curtain", "sensors": ["curtain"]}]
        del keys["require"]
        for latch in (True, False):
            keys["sensor"][0]["latch"] = latch
            keys["sensor"][0]["muted_by"] = [] if latch else ["forklift"]
            study = pr.Study(keys, folder=ROOT / "scenes")
            said = []
            for snapshot in range(8):
                with warnings.catch_warnings():
                    # That a latch takes something for granted.
                    warnings.simplefilter("ignore", pr.InputWarning)
                    truth = study.truth(snapshot=snapshot)
                    found = study.labels("here", snapshot=snapshot, backend="cpu")
                middles = [
                    low + VOXEL_M * (np.arange(count) + 0.5) for low, count in zip(truth.origin_m, truth.occupied.shape)
                ]
                x, y, z = np.meshgrid(*middles, indexing="ij")
                box = (x > 0) & (x < 0.1) & (y > -0.9) & (y < 1.0) & (z > 0.1) & (z < 2.2)
                zone = (x > -3.9) & (x < 0) & (y > -2.9) & (y < 2.9) & (z > 0.1) & (z < 2.0)
                people = truth.human & truth.occupied
                # The forklift is 1.2 m long, and its middle drives in steps of half a metre.
                middle = 2.8 - 0.5 * snapshot
                is_muted = not latch and middle - 0.6 < 0.1 and middle + 0.6 > 0
                felt = people & (box | zone) if latch else people & box
                is_on = bool(not is_muted and (felt.any() or (box & truth.occupied).any()))
                expected = np.where(zone & is_on, pr.OCCUPIED, pr.UNKNOWN)
                np.testing.assert_array_equal(found.labels, expected, f"snapshot {snapshot}")
                np.testing.assert_array_equal(found.hits, felt & is_on, f"snapshot {snapshot}")
                said.append((is_muted, is_on))
            on = [is_on for _, is_on in said]
            self.assertEqual(sum(is_muted for is_muted, _ in said), 0 if latch else 2)
            self.assertEqual(on, [latch] * 8, said)

    def test_verdicts_warn_of_a_latch_that_does_not_hold(self):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            verdicts = pr.Study.load(ROOT / "scenes/latching.toml").judge("here", backend="cpu", progress=False)
        self.assertTrue((verdicts.verdict == "PASS").all(), verdicts)
        told = [str(one.message) for one in told]
        self.assertTrue(any("its latch does not hold" in words for words in told), told)


if __name__ == "__main__":
    unittest.main()
