"""What methods say and draw of one choice of poses is what the commands say and draw, for studies in memory as well."""

import os
import pathlib
import shutil
import tempfile
import tomllib
import unittest
import warnings

import numpy as np
import pandas as pd

import perirobot as pr
from shared import ROOT, program, scenes


def in_memory(name: str, **changes: object) -> pr.Study:
    """A study that ships, made of its keys."""
    with open(ROOT / "scenes" / name, "rb") as file:
        return pr.Study({**tomllib.load(file), **changes}, folder=ROOT / "scenes")


class Folders(unittest.TestCase):
    def folder(self) -> str:
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        return folder

    def run_program(self, *words: object, code: int = 0) -> str:
        done = program(*words)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stdout


class Commands(Folders):
    def test_why_says_what_the_command_prints(self):
        folder = self.folder()
        self.run_program("sweep", "scenes/tiny.toml", "--out", folder)
        study = in_memory("tiny.toml")
        poses = study._native.choices(0)[0][0]
        named = {"combination": study.combinations[0]}
        why = study.why(poses, **named, backend="cpu")
        words = ["--pose", poses, "--combination", named["combination"], "--backend", "cpu"]
        self.assertEqual(str(why), self.run_program("why", folder, *words))
        # The reasons of all voxels are the unknown voxels of the sweep.
        rows = study.sweep("cpu", progress=False).to_pandas()
        rows = rows[(rows.poses == poses) & (rows.combination == named["combination"]) & (rows.snapshot == 0)]
        rows = rows[(rows.scene == study.scenes[0]) & (rows.representation == rows.representation.iloc[0])]
        unknown = rows[rows.repeat == 0].set_index("region")
        reasons = why.to_pandas().groupby("region")[["voxels_occupied", "voxels_free"]].sum()
        for region, counted in reasons.iterrows():
            self.assertEqual(list(counted), list(unknown.loc[region, ["uo", "uf"]]), region)

    def test_approach_writes_the_files_of_the_command(self):
        theirs, own = self.folder(), self.folder()
        both = "camera:wall/front;camera:wall/back"
        words = ["--pose", both, "--dead", "camera:wall/back", "--out", theirs]
        said = self.run_program("approach", "scenes/approach.toml", *words)
        near = in_memory("approach.toml").approach(both, own, dead=["camera:wall/back"], progress=False)
        self.assertTrue(said.startswith(str(near)), str(near))
        for name in sorted(os.listdir(theirs)):
            self.assertEqual((pathlib.Path(own) / name).read_bytes(), (pathlib.Path(theirs) / name).read_bytes(), name)
        frame = near.to_pandas()
        self.assertEqual(set(frame.case), {"without camera:wall/back"})
        self.assertLess(frame.deepest_m.min(), study_alone(both))

    def test_pictures_are_those_of_the_command(self):
        folder = self.folder()
        study = in_memory("tiny.toml")
        poses, combination = study._native.choices(0)[0][0], study.combinations[0]
        choice = ["--pose", poses, "--combination", combination]
        for name, words, keys in [
            ("cell.png", [], {}),
            ("pose.png", [*choice, "--from", "top"], {"poses": poses, "combination": combination, "eye": "top"}),
            ("walls.png", ["--open", "0", "--points", "0", *choice], {"poses": poses, "combination": combination, "open": 0, "points": 0}),
            ("plan.svg", choice, {"poses": poses, "combination": combination, "floor_plan": True}),
            (
                "inside.png",
                ["--from", "0.5,0.4,1.5", "--look-at", "0,0,0", "--colour", "height", "--size", "320x240", "--open", "0"],
                {"eye": (0.5, 0.4, 1.5), "look_at": (0, 0, 0), "colour": "height", "size": (320, 240), "open": 0},
            ),
        ]:
            with self.subTest(name):
                path = pathlib.Path(folder) / name
                self.run_program("render", "scenes/tiny.toml", *words, "--out", path, "--backend", "cpu")
                picture = study.render(**keys, backend="cpu")
                self.assertEqual(picture.data, path.read_bytes())
                self.assertEqual(picture.kind, path.suffix[1:])
                picture.save(path)
                self.assertEqual(picture._repr_png_() is None, picture.kind == "svg")

    def test_files_for_other_programs_are_those_of_the_command(self):
        swept, theirs, own = self.folder(), self.folder(), self.folder()
        self.run_program("sweep", "scenes/tiny.toml", "--out", swept)
        study = in_memory("tiny.toml")
        poses, combination = study._native.choices(0)[0][-1], study.combinations[0]
        words = ["--pose", poses, "--combination", combination, "--out", theirs, "--backend", "cpu"]
        said = self.run_program("export", swept, *words)
        files = study.export(poses, own, combination=combination, backend="cpu")
        self.assertEqual(sorted(files), sorted(os.listdir(theirs)))
        self.assertTrue(any(name.endswith(".mcap") for name in files))
        for name, holds in files.items():
            self.assertIn(holds, said)
            self.assertEqual((pathlib.Path(own) / name).read_bytes(), (pathlib.Path(theirs) / name).read_bytes(), name)

    def test_a_named_choice_is_judged_as_the_command_does(self):
        folder = self.folder()
        (copy,) = [scenes(folder)]
        study = pr.Study.load(copy / "judge.toml", voxel_size_m=0.1)
        out = self.folder()
        self.run_program("sweep", copy / "judge.toml", "--voxel-size", "0.1", "--out", out)
        poses = study._native.choices(0)[0][-1]
        self.assertIn(program("judge", out, "--pose", poses).returncode, (0, 4))
        expected = pd.read_csv(f"{out}/requirements.csv")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = study.judge(poses, backend="cpu", progress=False)
        pd.testing.assert_frame_equal(found, expected)
        # One that no combination lists.
        first, second = (study._native.choices(0)[0][n].split(";")[0] for n in (0, -1))
        self.assertNotEqual(first, second)
        own = study.judge(f"{first};{second}", backend="cpu", progress=False)
        self.assertEqual(len(own), len(expected))

    def test_reports_are_written(self):
        folder = self.folder()
        study = pr.Study.load(ROOT / "scenes/judge.toml", voxel_size_m=0.2)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            page = study.report(f"{folder}/own.html", backend="cpu", best=1, progress=False)
            best = study.choose(objective="parts_detected", region="robot", at_most=1, progress=False)
            chosen = study.report(f"{folder}/best.html", best, backend="cpu", best=1, progress=False)
            study.sweep("cpu", out=f"{folder}/swept", progress=False)
            study.report(f"{folder}/swept.html", f"{folder}/swept", backend="cpu", best=1, progress=False)
        for path, words in [(page, "7 of 10 body parts are seen"), (chosen, "front")]:
            text = pathlib.Path(path).read_text()
            self.assertTrue(text.startswith("<!DOCTYPE html>"))
            self.assertIn(words, text)
        with self.assertRaisesRegex(ValueError, "is not a folder"):
            study.report(f"{folder}/none.html", f"{folder}/nowhere", progress=False)

    def test_what_is_wrong_is_refused(self):
        study = pr.Study.load(ROOT / "scenes/approach.toml")
        for call, message in [
            (lambda: study.why("camera:wall/fro"), "did you mean camera:wall/front"),
            (lambda: study.why("camera:wall/front", dead=["camera:wall/front"]), "no sensor is left to look at"),
            (lambda: study.why("camera:wall/front", draw=0, dead=["a"]), "dead, draw, posture: say one of them"),
            (lambda: study.approach("camera:wall/front", draw=0), r"has no \[mounting_error\]"),
            (lambda: study.render(fov_deg=190), "fov_deg 190: must be from 1 to 150"),
            (lambda: study.render(size=(10, 600)), "size 10 x 600: must be from 64 to 4096 pixels"),
            (lambda: study.render(eye="nowhere"), 'eye "nowhere": must be three numbers in metres'),
            (lambda: study.render(eye=(1, 2)), "eye = .*must be x, y, z in metres"),
            (lambda: study.render(colour="red"), 'colour = "red": must be "label", "role"'),
            (lambda: study.render(only_region="nowhere"), "only_region nowhere"),
            (lambda: study.render(approach=True), "poses: name a choice of poses"),
            (lambda: pr.Study.load(ROOT / "scenes/tiny.toml").judge("camera:1"), "no require"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                call()


def study_alone(poses: str) -> float:
    """How near a body comes to a choice of which no sensor is dead."""
    return float(pr.Study.load(ROOT / "scenes/approach.toml").approach(poses, progress=False).to_pandas().deepest_m.min())


class Sums(Folders):
    def test_scores_over_moments_are_those_of_the_command(self):
        for name in ("tiny.toml", "sensors.toml", "tutorial/study.toml"):
            with self.subTest(name):
                theirs, own = self.folder(), self.folder()
                voxel = ["--voxel-size", "0.2"] if "tutorial" in name else []
                self.run_program("sweep", f"scenes/{name}", "--out", theirs, *voxel)
                study = pr.Study.load(ROOT / "scenes" / name, voxel_size_m=0.2 if voxel else None)
                swept = study.sweep("cpu", progress=False)
                self.assertEqual(swept._all().scores(), pathlib.Path(theirs, "scores.csv").read_bytes())
                pd.testing.assert_frame_equal(pr.Result.load(theirs).scores(), swept.scores())
                again = study.sweep("cpu", out=own, progress=False)
                pd.testing.assert_frame_equal(again.to_pandas(), swept.to_pandas())
                for table in ("scores.csv", "results.csv", "poses.csv"):
                    self.assertEqual(pathlib.Path(own, table).read_bytes(), pathlib.Path(theirs, table).read_bytes())

    def test_moments_that_last_longer_weigh_more(self):
        copy, out = scenes(self.folder()), self.folder()
        cell = next((copy / "sensors").glob("*cell*.toml"))
        cell.write_text(cell.read_text().replace("[object.snapshots]", "[object.snapshots]\ndwell_s = [3, 1]", 1))
        self.run_program("sweep", copy / "sensors.toml", "--out", out)
        swept = pr.Study.load(copy / "sensors.toml").sweep("cpu", progress=False)
        self.assertEqual(swept._all().scores(), pathlib.Path(out, "scores.csv").read_bytes())
        scores = swept.scores()
        self.assertTrue((scores.f1_weighted != scores.f1_mean).any())

    def test_pooled_scores_are_those_of_summed_counts(self):
        study = in_memory("sensors.toml")
        swept = study.sweep("cpu", progress=False)
        keys = ["combination", "poses", "representation", "region"]
        sums = swept.to_pandas().groupby(keys)[["tp", "fp", "fn", "uo", "uf"]].sum()
        pooled = swept.scores().query("scene == '*'").set_index(keys).f1_pooled
        for key, (tp, fp, fn, uo, uf) in sums.iterrows():
            under = 2 * tp + fp + fn + uo + uf
            np.testing.assert_allclose(pooled[key], 2 * tp / under if under else np.nan, atol=5e-7)

    def test_baselines_are_counted_of_the_truth(self):
        study = in_memory("sensors.toml")
        rows = study.baselines().to_pandas().set_index(["scene", "snapshot", "region", "baseline"]).sort_index()
        for scene, snapshot in {(scene, snapshot) for scene, snapshot, *_ in rows.index}:
            truth = study.truth(scene, snapshot)
            for name, region in truth.regions.items():
                there, all_ = np.count_nonzero(truth.occupied & region), np.count_nonzero(region)
                moment = rows.loc[(scene, snapshot, name)]
                self.assertEqual((moment.tp["all_occupied"], moment.fp["all_occupied"]), (there, all_ - there))
                self.assertEqual((moment.fn["all_free"], moment.tn["all_free"]), (there, all_ - there))
                self.assertEqual((moment.uo["nothing_seen"], moment.uf["nothing_seen"]), (there, all_ - there))
                self.assertEqual(moment.fp["ceiling"] + moment.fn["ceiling"], 0)

    def test_a_recorded_map_has_no_scores_over_moments(self):
        study = pr.Study.load(ROOT / "scenes/tiny.toml")
        labels = study.labels(study._native.choices(0)[0][0], combination=study.combinations[0])
        scored = pr.score_map(labels, truth=study)
        self.assertGreater(len(scored), 0)
        with self.assertRaisesRegex(ValueError, "belong to a sweep"):
            scored.scores()


class Axes(unittest.TestCase):
    def test_cubes_have_the_places_of_poses(self):
        study = pr.Study.load(ROOT / "scenes/sensors.toml")
        swept = study.sweep("cpu", progress=False)
        with_several = placed = 0
        for combination in study.combinations:
            cube = swept.to_xarray(combination)
            if "x_m" not in cube.coords:
                self.assertNotIn(":", str(cube.pose.values[0]))
                continue
            members = cube.x_m.dims == ("pose", "member")
            with_several += members
            for choice in cube.pose.values:
                for number, named in enumerate(str(choice).split(";")):
                    sensor, _, pose = named.partition(":")
                    if sensor not in study.sensors:
                        continue
                    names, rows = study.poses(sensor)
                    at = cube.sel(pose=choice)
                    at = at.isel(member=number) if members else at
                    found = [float(at[axis]) for axis in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")]
                    if np.isnan(found).all():
                        continue  # A sensor that is set up without a pose.
                    np.testing.assert_array_equal(found, rows[names.index(pose)])
                    placed += 1
        self.assertGreater(with_several, 0)
        self.assertGreater(placed, 5)

    def test_voxels_have_their_axes_in_metres(self):
        study = pr.Study.load(ROOT / "scenes/tiny.toml")
        poses, combination = study._native.choices(0)[0][0], study.combinations[0]
        labels = study.labels(poses, combination=combination)
        cell = labels.to_xarray()
        truth = study.truth().to_xarray()
        i, j, k = np.argwhere(labels.labels == pr.OCCUPIED)[0]
        middle = labels.origin_m + (np.array([i, j, k]) + 0.5) * labels.voxel_size_m
        at = dict(zip("xyz", middle))
        self.assertEqual(int(cell.labels.sel(at, method="nearest")), pr.OCCUPIED)
        np.testing.assert_allclose([cell.x[i], cell.y[j], cell.z[k]], middle)
        self.assertEqual(cell.attrs["poses"], poses)
        self.assertEqual(list(truth.region.values), study.regions)
        np.testing.assert_array_equal(truth.regions.sel(region=study.regions[0]), study.truth().regions[study.regions[0]])

    def test_hits_are_those_of_the_sweep(self):
        study = pr.Study.load(ROOT / "scenes/sensors.toml")
        keys = ["scene", "snapshot", "repeat", "combination", "poses", "representation", "region"]
        rows = study.sweep("cpu", progress=False).to_pandas().set_index(keys).hit_human
        cast = [name for name in study.combinations if name in ("camera", "lidar")] or study.combinations[:1]
        seen = 0
        for combination in cast:
            for labels in study.each_labels(combination=combination, progress=False):
                truth = study.truth(labels.scene, labels.snapshot)
                self.assertTrue((labels.hits <= truth.occupied).all(), "a return comes from something")
                moment = (labels.scene, labels.snapshot, labels.repeat, combination, labels.poses, labels.representation)
                for name, region in truth.regions.items():
                    hit = np.count_nonzero(labels.hits & truth.human & region)
                    self.assertEqual(hit, rows[(*moment, name)])
                    seen += hit
        self.assertGreater(seen, 0)


if __name__ == "__main__":
    unittest.main()
