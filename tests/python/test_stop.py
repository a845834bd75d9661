"""Jobs tell how far they are, and Ctrl-C stops them in each of their parts."""

import json
import re
import signal
import subprocess
import sys
import tempfile
import unittest
import warnings
from collections.abc import Callable

import tqdm.auto

import perirobot as pr
from shared import ROOT, priced, scenes

# Presses Ctrl-C when a part of a job has begun, and tells of each part what there was to do and what was done when the job
# ended: one that did not stop has done all of it, or begun the next.
STOPPED = """
import json, os, signal, sys, threading, warnings
import tqdm.auto
import perirobot as pr

parts = []

class Bar(tqdm.auto.tqdm):
    def __init__(self, *args, **keys):
        super().__init__(*args, **keys)
        parts.append([keys["unit"].strip(), keys["total"], 0])
        if (keys["unit"].strip(), keys["total"] is None) == (sys.argv[1], sys.argv[2] == "True"):
            threading.Timer(0.2, os.kill, [os.getpid(), signal.SIGINT]).start()

    def update(self, n=1):
        parts[-1][2] += n
        return super().update(n)

tqdm.auto.tqdm = Bar
warnings.simplefilter("ignore")
study = pr.Study.load(sys.argv[3], voxel_size_m=float(sys.argv[4]))
try:
    exec(sys.argv[5])
    print("it ran to its end")
finally:
    print(json.dumps(parts))
"""

# A hang fails; nothing else depends on the time.
TOO_LONG_S = 600


class Stops(unittest.TestCase):
    def stops(self, part: str, is_endless: bool, study: object, voxel_size_m: float, job: str) -> None:
        words = [part, str(is_endless), str(study), str(voxel_size_m), job]
        done = subprocess.run(
            [sys.executable, "-c", STOPPED, *words], capture_output=True, text=True, timeout=TOO_LONG_S
        )
        self.assertNotIn("ran to its end", done.stdout)
        self.assertIn("KeyboardInterrupt", done.stderr)
        self.assertEqual(done.returncode, -signal.SIGINT, done.stderr)
        *_, [last, total, told] = json.loads(done.stdout)
        self.assertEqual((last, total is None), (part, is_endless), done.stdout)
        if not is_endless:
            self.assertLess(told, total, f"{part}: it went on to the end")

    def test_a_sweep(self):
        self.stops("poses", False, ROOT / "scenes/paper/exp1.toml", 0.05, "study.sweep('cpu')")

    def test_labels(self):
        job = "list(study.each_labels(combination='camera', backend='cpu'))"
        # All are made by one call.
        self.stops("labels", False, ROOT / "scenes/paper/exp1.toml", 0.2, job)

    def test_choose_while_it_casts(self):
        self.stops("poses", False, ROOT / "scenes/paper/exp1-choose.toml", 0.05, "study.choose(backend='cpu')")

    def test_choose_while_it_searches(self):
        keys = "at_most=8, budget=100000.0, over='mean', objective='kappa', require=[]"
        self.stops("sets", True, ROOT / "scenes/choose.toml", 0.1, f"study.choose(backend='cpu', {keys})")

    def test_cheapest_while_it_searches(self):
        with tempfile.TemporaryDirectory() as folder:
            study = priced(folder, 0.5)
            study.write_text(re.sub(r"(?m)^draws = .*$", "draws = 1000", study.read_text()))
            self.stops("sets", True, study, 0.1, "study.cheapest(backend='cpu')")

    def test_verify(self):
        job = "best = study.choose(backend='cpu', at_most=4, progress=False)\nbest.verify('cpu')"
        with tempfile.TemporaryDirectory() as folder:
            study = scenes(folder) / "paper/exp1-choose.toml"
            self.stops("steps", False, study, 0.15, job)

    def test_judge(self):
        with tempfile.TemporaryDirectory() as folder:
            study = scenes(folder) / "judge.toml"
            study.write_text(re.sub(r"(?m)^draws = .*$", "draws = 1000", study.read_text()))
            keys = "objective='parts_detected', region='robot', at_most=2, backend='cpu', progress=False"
            self.stops("cases", False, study, 0.1, f"study.judge(study.choose({keys}), backend='cpu')")


class TellsHowFar(unittest.TestCase):
    def parts(self, job: Callable[[], object]) -> list[tuple[str, int | None, int]]:
        """What is done in each part of a job, how much of it there is, and how much was told."""
        told = []

        class Bar(tqdm.auto.tqdm):
            def __init__(self, *args, **keys):
                super().__init__(*args, **keys)
                told.append([keys["unit"].strip(), keys["total"], 0])

            def update(self, n=1):
                told[-1][2] += n
                return super().update(n)

        original, tqdm.auto.tqdm = tqdm.auto.tqdm, Bar
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                job()
        finally:
            tqdm.auto.tqdm = original
        return [tuple(part) for part in told]

    def test_every_part_of_each_job(self):
        study = pr.Study.load(ROOT / "scenes/judge.toml")
        keys = {"objective": "parts_detected", "region": "robot", "at_most": 2, "backend": "cpu"}
        best = []
        for job, expected in [
            (lambda: best.append(study.choose(**keys)), ["poses", "sets", "sets"]),
            (lambda: best[0].verify("cpu"), ["poses", "steps"]),
            (lambda: study.judge(best[0], backend="cpu"), ["cases"]),
        ]:
            parts = self.parts(job)
            self.assertEqual([part for part, _, _ in parts], expected)
            for part, total, done in parts:
                # How long a search takes nobody knows.
                self.assertEqual(done, total or 0, part)
        with tempfile.TemporaryDirectory() as folder:
            costs = pr.Study.load(priced(folder, 0.5))
            parts = self.parts(lambda: costs.cheapest(backend="cpu"))
        self.assertEqual([part for part, _, _ in parts], ["poses", "sets", "sets", "cases"])
        one = pr.Study.load(ROOT / "scenes/tiny.toml")
        rows = len(one.poses("camera")[0])
        labels = self.parts(lambda: list(one.each_labels(combination="camera", backend="cpu")))
        self.assertEqual(labels, [("labels", rows, rows)])
        self.assertEqual(self.parts(lambda: one.sweep("cpu", progress=False)), [])

    def test_what_a_bar_raises_ends_the_job_and_is_told(self):
        class Broken(tqdm.auto.tqdm):
            def update(self, n=1):
                raise RuntimeError("no more paper")

        original, tqdm.auto.tqdm = tqdm.auto.tqdm, Broken
        try:
            with self.assertRaisesRegex(RuntimeError, "no more paper"):
                pr.Study.load(ROOT / "scenes/tiny.toml").sweep("cpu")
        finally:
            tqdm.auto.tqdm = original


if __name__ == "__main__":
    unittest.main()
