"""The best sets from Python are those of `perirobot choose`, and their proof is checked."""

import pathlib
import tempfile
import tomllib
import unittest

import perirobot as pr
from shared import ROOT, program


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
        with self.assertRaisesRegex(ValueError, r"tiny\.toml: .*choose.*say what is looked for"):
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
                self.assertEqual(set(verdicts.combination), {"best 1", "best 2", "tie 1"})
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


if __name__ == "__main__":
    unittest.main()
