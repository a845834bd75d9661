"""The best sets from Python are those of `perirobot choose`, and their proof is checked."""

import json
import pathlib
import tempfile
import tomllib
import unittest

import perirobot as pr
from shared import ROOT, priced, program


class Choose(unittest.TestCase):
    def test_the_answer_is_that_of_the_command_line(self):
        study = pr.Study.load(ROOT / "scenes/choose.toml")
        with tempfile.TemporaryDirectory() as out:
            done = program("choose", "scenes/choose.toml", "--out", out, "--backend", "cpu")
            self.assertEqual(done.returncode, 0, done.stderr)
            best = study.choose(backend="cpu")
            for name in ["front.csv", "sets.csv", "choose.json", "results.csv", "scores.csv"]:
                told = [(pathlib.Path(folder) / name).read_text() for folder in [best.folder, out]]
                self.assertEqual(*(text.replace(str(ROOT) + "/", "") for text in told))
        self.assertEqual(best.front().at_most.tolist()[0], 1)
        self.assertIsNone(best.refined())
        self.assertIsNone(best.currency)
        checked = best.verify("cpu")
        self.assertEqual(checked["open"], 0)
        self.assertGreater(checked["proven"], 2)

    def test_keys_may_be_others_than_the_study_has(self):
        study = pr.Study.load(ROOT / "scenes/choose.toml")
        with tempfile.TemporaryDirectory() as out:
            one = study.choose(out, at_most=1, refine=True, backend="cpu")
            self.assertEqual(set(one.front().at_most), {1})
            self.assertEqual(one.folder, out)
            self.assertIsNotNone(one.refined())
            one.verify("cpu")
        # The study itself still asks what it asked.
        self.assertEqual(study.choose(backend="cpu").front().at_most.max(), 3)
        with self.assertRaisesRegex(ValueError, r"(?s)choose\.toml: .*at_most"):
            study.choose(at_most=0)
        with self.assertRaisesRegex(ValueError, r"(?s)choose\.toml: .*at_mots"):
            study.choose(at_mots=1)

    def test_a_study_that_asks_nothing_is_told_how(self):
        study = pr.Study.load(ROOT / "scenes/tiny.toml")
        with self.assertRaisesRegex(ValueError, r"tiny\.toml: .*choose.*add \[choose\]"):
            study.choose()
        best = study.choose(objective="f1", region="robot", at_most=1, backend="cpu")
        [answer] = best.front().itertuples()
        frame = study.sweep("cpu", progress=False).to_pandas()
        rows = frame[(frame.poses == answer.poses) & (frame.region == "robot")]
        self.assertIn(answer.f1, rows.f1.tolist())

    def test_the_best_sets_are_judged_as_the_command_line_does(self):
        keys = {"objective": "parts_detected", "region": "robot", "at_most": 2}
        file = ROOT / "scenes/judge.toml"
        in_memory = pr.Study(tomllib.loads(file.read_text()), folder=file.parent)
        told = []
        for study in [pr.Study.load(file), in_memory]:
            with tempfile.TemporaryDirectory() as out:
                best = study.choose(out, backend="cpu", **keys)
                names = ["requirements.csv", "conditions.csv", "judge.json"]
                tables = [pathlib.Path(out) / name for name in names]
                verdicts = study.judge(best, backend="cpu")
                told.append([table.read_text() for table in tables])
                self.assertEqual(len(verdicts), told[-1][0].count("\n") - 1)
                self.assertEqual(set(verdicts.combination), {"best 1 for 450", "best 2 for 900", "tie 1"})
                self.assertEqual(set(verdicts.verdict), {"PASS", "FAIL"})
                if study is not in_memory:
                    self.assertEqual(program("judge", out, "--backend", "cpu").returncode, 4)
                    told.append([table.read_text() for table in tables])
        self.assertEqual(told[0], told[1])
        self.assertEqual(told[0], told[2])
        tiny = pr.Study.load(ROOT / "scenes/tiny.toml")
        with self.assertRaisesRegex(ValueError, "require"):
            tiny.judge(tiny.choose(objective="f1", region="robot", at_most=1, backend="cpu"))

    def test_a_proof_that_was_altered_is_refused(self):
        with tempfile.TemporaryDirectory() as out:
            best = pr.Study.load(ROOT / "scenes/choose.toml").choose(out, at_most=2, backend="cpu")
            proof = pathlib.Path(out) / "choose.json"
            text = proof.read_text()
            first = best.front().poses.iloc[0].removeprefix("camera:")
            proof.write_text(text.replace(first, "left-wall/0/0"))
            with self.assertRaises(ValueError):
                best.verify("cpu")
            proof.write_text(text)
            self.assertTrue(best.verify("cpu"))
            results = pathlib.Path(out) / "results.csv"
            table = results.read_text()
            results.write_text(table[: table.rindex(",") + 1] + "7\n")
            with self.assertRaisesRegex(ValueError, "results.csv"):
                best.verify("cpu")


class Cheapest(unittest.TestCase):
    def test_the_answer_is_that_of_the_command_line(self):
        with tempfile.TemporaryDirectory() as folder:
            file = priced(folder, 0.5)
            # Draws of mounts are judged elsewhere; they take the oracle long.
            text = file.read_text().replace(', "mounting_error"', "")
            file.write_text(text.replace('objective = "cost"', 'front = "requirements"'))
            out = pathlib.Path(folder) / "out"
            done = program("choose", file, "--out", out, "--backend", "cpu")
            self.assertEqual(done.returncode, 0, done.stderr)
            study = pr.Study.load(file)
            found = study.cheapest(backend="cpu", progress=False)
            names = ["cheapest.json", "cheapest.csv", "requirements.csv", "judge.json", "results.csv", "scores.csv"]
            for name in names:
                self.assertEqual((pathlib.Path(found.folder) / name).read_text(), (out / name).read_text(), name)
            self.assertEqual(found.sentence, done.stdout.splitlines()[0])
            front = found.front()
            self.assertEqual(front["aim"].tolist(), ["all"] + ["without"] * 3 + ["number"] * 2)
            self.assertTrue(found.passes and found.proven)
            self.assertEqual((found.cost, found.bound, found.reasons), (front.cost[0], front.cost[0], []))
            first = found.sets[0]
            self.assertEqual((first.name, first.cost, first.poses), ("cheapest", found.cost, front.poses[0]))
            self.assertEqual(sum(one.cost for one in first.sensors), found.cost)
            self.assertIn("wall, x ", first.sensors[0].place)
            self.assertEqual({one.poses for one in found.sets}, set(front.poses))
            verdicts = found.verdicts()
            self.assertEqual(set(verdicts[verdicts.combination == "cheapest"].verdict), {"PASS"})
            self.assertIn("without", found._repr_html_())
            # A folder opens again, and other keys ask something else.
            again = pr.Purchase.load(out)
            self.assertEqual((again.sentence, again.sets), (found.sentence, found.sets))
            checked = again.verify("cpu", progress=False)
            self.assertEqual((checked["sets"], checked["open"]), (front.cost.count(), 0))
            self.assertGreaterEqual(checked["proven"], 1)
            one = study.cheapest(at_most=1, then="f1", region="robot", backend="cpu", progress=False)
            self.assertTrue(all(len(each.sensors) == 1 for each in one.sets))
            twice = study.cheapest(then="seen_twice", region="robot", backend="cpu", progress=False)
            self.assertGreater(twice.sets[0].score, 0)
            # All sets of the answer are judged, once each.
            self.assertEqual(program("judge", out, "--backend", "cpu").returncode, 0)
            self.assertEqual(set(study.judge(again, backend="cpu").combination), {each.name for each in found.sets})

    def test_why_nothing_passes_is_told(self):
        with tempfile.TemporaryDirectory() as folder:
            found = pr.Study.load(priced(folder, 0.7)).cheapest(backend="cpu", progress=False)
            self.assertEqual((found.passes, found.cost, found.bound, found.proven), (False, None, None, True))
            [reason] = found.reasons
            self.assertEqual(reason.requirement, "7 of 10 body parts are seen")
            self.assertIn("list another place", reason.why)
            self.assertEqual(found.sets[0].name, "nearest")
            self.assertTrue(found.sentence.startswith("no allowed set passes all; "), found.sentence)

    def test_a_stopped_answer_has_its_bound(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "out"
            pr.Study.load(priced(folder, 0.5)).cheapest(out, backend="cpu", progress=False)
            file = out / "cheapest.json"
            report = json.loads(file.read_text())
            report["points"][0].update(proven=False, no_set_below=450.5)
            file.write_text(json.dumps(report))
            found = pr.Purchase.load(out)
            self.assertEqual((found.proven, found.bound), (False, 450.5))
            with self.assertRaisesRegex(ValueError, "cheapest"):
                found.verify("cpu", progress=False)

    def test_what_cannot_be_asked_is_told(self):
        with tempfile.TemporaryDirectory() as folder:
            study = pr.Study.load(priced(folder, 0.5))
            with self.assertRaisesRegex(ValueError, r"requests the cheapest set that passes"):
                study.choose(objective="cost")
            with self.assertRaisesRegex(ValueError, r"(?s)judge\.toml: .*at_mots"):
                study.cheapest(at_mots=1)
            with self.assertRaisesRegex(ValueError, "has no cheapest.json: name a folder that"):
                pr.Purchase.load(folder)
        with self.assertRaisesRegex(ValueError, r"tiny\.toml"):
            pr.Study.load(ROOT / "scenes/tiny.toml").cheapest(progress=False)


if __name__ == "__main__":
    unittest.main()
