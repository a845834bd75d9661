"""What is truly there, as Python has it, counted by numpy against the labels gives the counts of the sweep."""

import unittest

import numpy as np

import perirobot as pr
from shared import ROOT

#: Columns of counts: which label there is, and what is truly there.
COUNTS = {
    "tp": (pr.OCCUPIED, True, None),
    "fp": (pr.OCCUPIED, False, None),
    "fn": (pr.FREE, True, None),
    "tn": (pr.FREE, False, None),
    "uo": (pr.UNKNOWN, True, None),
    "uf": (pr.UNKNOWN, False, None),
    "tp_human": (pr.OCCUPIED, True, "human"),
    "fn_human": (pr.FREE, True, "human"),
    "uo_human": (pr.UNKNOWN, True, "human"),
    "tp_robot": (pr.OCCUPIED, True, "robot"),
    "fn_robot": (pr.FREE, True, "robot"),
    "uo_robot": (pr.UNKNOWN, True, "robot"),
}


class Truths(unittest.TestCase):
    def test_labels_against_the_truth_are_the_counts_of_the_sweep(self):
        study = pr.Study.load(ROOT / "scenes/sensors.toml")
        keys = ["scene", "snapshot", "repeat", "combination", "poses", "representation", "region"]
        rows = study.sweep("cpu", progress=False).to_pandas().set_index(keys)
        seen = 0
        for combination in study.combinations:
            for labels in study.each_labels(combination=combination, progress=False):
                truth = study.truth(labels.scene, labels.snapshot)
                np.testing.assert_array_equal(truth.origin_m, labels.origin_m)
                self.assertEqual((truth.scene, truth.snapshot), (labels.scene, labels.snapshot))
                self.assertEqual(list(truth.regions), study.regions)
                moment = (labels.scene, labels.snapshot, labels.repeat)
                for name, region in truth.regions.items():
                    row = rows.loc[(*moment, combination, labels.poses, labels.representation, name)]
                    for column, (label, is_there, whose) in COUNTS.items():
                        voxels = region & (labels.labels == label) & (truth.occupied == is_there)
                        if whose is not None:
                            voxels &= getattr(truth, whose)
                        self.assertEqual(np.count_nonzero(voxels), row[column], (moment, labels.poses, name, column))
                        seen += int(row[column] > 0)
        self.assertGreater(seen, 100)

    def test_planes_are_those_of_the_moment(self):
        study = pr.Study.load(ROOT / "scenes/sensors.toml")
        one, next_ = study.truth(), study.truth(study.scenes[0], 1)
        self.assertEqual((one.occupied.dtype, one.occupied.ndim), (np.bool_, 3))
        self.assertTrue(one.human.any() and one.robot.any() and (one.human <= one.occupied).all())
        self.assertFalse(np.array_equal(one.occupied, next_.occupied), "somebody moves")

    def test_scenes_are_told_apart(self):
        region = {"name": "all", "box": {"min_m": [0, 0, 0], "max_m": [1, 1, 1]}}
        camera = {"name": "camera", "kind": "rgbd", "fov_deg": [87, 58], "resolution_px": [8, 8], "range_m": [0.3, 6]}
        camera["poses"] = [{"name": "spot", "list": [{"position_m": [0.5, 0.5, 0.5], "facing": [1, 0, 0]}]}]
        arrays = {f"cell {seed}": np.random.default_rng(seed).random((10, 10, 10)) < 0.1 for seed in range(3)}
        cells = {name: pr.Cell(occupied, 0.1) for name, occupied in arrays.items()}
        study = pr.Study({"region": [region], "sensor": [camera]}, scenes=cells)
        for name, occupied in arrays.items():
            np.testing.assert_array_equal(study.truth(name).occupied, occupied)

    def test_moments_that_are_not_there_are_refused(self):
        study = pr.Study.load(ROOT / "scenes/sensors.toml")
        with self.assertRaisesRegex(ValueError, "scene = 'nowhere': must be one of"):
            study.truth("nowhere")
        with self.assertRaisesRegex(ValueError, "snapshot = 2: scene 'cell' has 2, counted from 0"):
            study.truth(snapshot=2)
        with self.assertRaisesRegex(ValueError, "snapshot = -1: must be a whole number"):
            study.truth(snapshot=-1)


if __name__ == "__main__":
    unittest.main()
