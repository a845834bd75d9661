"""Studies work in forked, spawned and served processes, as data loaders and vectorised environments start them."""

import copy
import importlib.util
import multiprocessing
import os
import pathlib
import pickle
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import pandas as pd

import perirobot as pr
import test_labels
from shared import ROOT, program


# Nothing but a hang depends on the time.
TOO_LONG_S = 300


@unittest.skipUnless(hasattr(os, "fork"), "this system has no fork")
class Processes(unittest.TestCase):
    def works(self, way: str, backend: str) -> None:
        """Runs `processes.py`, and ends it with all of its children if it hangs."""
        command = [sys.executable, str(pathlib.Path(__file__).with_name("processes.py")), way, backend]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
        with self.subTest(way, backend=backend), subprocess.Popen(command, **pipes, start_new_session=True) as job:
            try:
                said, _ = job.communicate(timeout=TOO_LONG_S)
            except subprocess.TimeoutExpired:
                os.killpg(job.pid, signal.SIGKILL)
                self.fail(f"{way}: it hangs")
            self.assertEqual(job.returncode, 0, said)

    def test_a_forked_child_counts_as_its_parent(self):
        for backend in ["cpu", "oracle", "gpu"]:
            self.works("fork", backend)
        self.works("fork while counting", "cpu")

    def test_ctrl_c_ends_a_forked_child(self):
        self.works("interrupt", "cpu")

    def test_pools_of_every_way_to_start(self):
        for way in multiprocessing.get_all_start_methods():
            self.works(f"pool {way}", "cpu")
        self.works("pool fork", "gpu")

    def test_workers_that_load_data(self):
        for way in multiprocessing.get_all_start_methods():
            self.works(f"loader {way}", "cpu")

    @unittest.skipUnless(importlib.util.find_spec("torch"), "optional: torch is large and not installed")
    def test_a_data_loader_of_torch(self):
        self.works("torch", "cpu")

    def test_environments_of_gymnasium(self):
        self.works("gymnasium", "cpu")


# A cube of 0.3 m, and a scene that has it.
FACES = ["1 3 2", "2 3 4", "5 6 7", "6 8 7", "1 2 5", "2 6 5", "3 7 4", "4 7 8", "1 5 3", "3 5 7", "2 4 6", "4 8 6"]
CUBE = "".join(f"v {x} {y} {z}\n" for x in (0, 0.3) for y in (0, 0.3) for z in (0, 0.3))
CUBE += "".join(f"f {face}\n" for face in FACES)
MESH = {"mesh": "meshes/post.obj", "up": "z", "unit": "m"}
SCENE = {"object": [{"name": "post", "role": "human", **MESH, "position_m": [1, 1, 0.4]}]}


class Copies(unittest.TestCase):
    def test_copies_and_pickles_count_the_same(self):
        loaded = pr.Study.load(ROOT / "scenes/tiny.toml", voxel_size_m=0.1, noiseless=True)
        for study in [loaded, test_labels.Cells().study(2)]:
            frame = study.sweep("cpu", progress=False).to_pandas()
            others = [copy.copy(study), copy.deepcopy(study), pickle.loads(pickle.dumps(study))]
            for other in [*others, pickle.loads(pickle.dumps(others[-1]))]:
                pd.testing.assert_frame_equal(other.sweep("cpu", progress=False).to_pandas(), frame)

    def test_a_file_that_changed_since_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            mesh = pathlib.Path(folder) / "meshes/post.obj"
            mesh.parent.mkdir()
            mesh.write_text(CUBE)
            keys = {**test_labels.Cells.KEYS, "grid": {"voxel_size_m": 0.1}}
            file = pr.Study(keys, scenes={"dict": SCENE}, folder=folder).save(folder)
            study = pr.Study.load(file)
            early = pickle.dumps(study)
            study.sweep("cpu", progress=False)
            pickled = pickle.dumps(study)
            mesh.write_text(CUBE + "# changed\n")
            # What is read only when scenes are put into voxels is compared then.
            other = pickle.loads(pickled)
            with self.assertRaisesRegex(ValueError, "post.obj: has changed since the study was pickled"):
                other.sweep("cpu", progress=False)
            # Before that there is nothing to compare it with.
            pickle.loads(early).sweep("cpu", progress=False)
            scene = pathlib.Path(folder) / "dict.toml"
            scene.write_text(scene.read_text() + "\n")
            # That of a study that was unpickled a moment ago is the same study.
            self.assertIs(pickle.loads(early), pickle.loads(early))
            pickle.loads(pickle.dumps(pr.Study.load(ROOT / "scenes/tiny.toml")))
            for old in [early, pickled]:
                with self.assertRaisesRegex(ValueError, "dict.toml: has changed since the study was pickled"):
                    pickle.loads(old)


class Folders(unittest.TestCase):
    def test_folders_of_sweeps_and_sets_open_again(self):
        study = pr.Study.load(ROOT / "scenes/choose.toml", voxel_size_m=0.1)
        with tempfile.TemporaryDirectory() as out:
            done = program("sweep", "scenes/tutorial/study.toml", "--voxel-size", "0.2", "--out", f"{out}/swept")
            self.assertEqual(done.returncode, 0, done.stderr)
            swept = pr.Result.load(pathlib.Path(out) / "swept").to_pandas()
            again = pr.Study.load(ROOT / "scenes/tutorial/study.toml", voxel_size_m=0.2)
            pd.testing.assert_frame_equal(swept, again.sweep("cpu", progress=False).to_pandas(), check_exact=True)
            best = study.choose(f"{out}/best", backend="cpu", progress=False)
            # The study is found by the folder, is the one that is named, or has the question that is named.
            for other in [pr.Best.load(best.folder), pr.Best.load(best.folder, study)]:
                pd.testing.assert_frame_equal(other.front(), best.front())
                self.assertEqual(other.verify("cpu", progress=False), best.verify("cpu", progress=False))
            one = study.choose(f"{out}/one", backend="cpu", progress=False, at_most=1)
            pr.Best.load(one.folder, study, at_most=1).verify("cpu", progress=False)
            with self.assertRaisesRegex(ValueError, "the study's question has changed"):
                pr.Best.load(one.folder, study).verify("cpu", progress=False)
            self.assertGreater(len(pr.Result.load(best.folder)), 0)
            in_memory = test_labels.Cells().study(1)
            keys = {"objective": "f1", "region": "all", "at_most": 1}
            made = in_memory.choose(f"{out}/made", backend="cpu", progress=False, **keys)
            missing = r"the study of this folder is not there: .*Best\.load\(folder, study"
            with self.assertRaisesRegex(ValueError, missing):
                pr.Best.load(made.folder).verify("cpu")
            pr.Best.load(made.folder, in_memory, **keys).verify("cpu", progress=False)
            with self.assertRaisesRegex(ValueError, "has no choose.json"):
                pr.Best.load(f"{out}/swept")
            with self.assertRaisesRegex(ValueError, "nowhere"):
                pr.Result.load("nowhere")

    def test_a_study_of_objects_is_saved_for_the_command_line(self):
        keys = {**test_labels.Cells.KEYS, "seed": 7}
        scenes = {
            "cell": pr.Cell(*test_labels.Cells.random(1)[:1], 0.1, people=test_labels.Cells.random(1)[1]),
            "dict": SCENE,
        }
        with tempfile.TemporaryDirectory() as folder:
            meshes = pathlib.Path(folder) / "home/meshes"
            meshes.mkdir(parents=True)
            (meshes / "post.obj").write_text(CUBE)
            study = pr.Study({**keys, "grid": {"voxel_size_m": 0.1}}, scenes=scenes, folder=meshes.parent)
            rows = study.sweep("cpu", progress=False).to_pandas()
            file = study.save(f"{folder}/saved")
            shutil.rmtree(meshes.parent)
            done = program("sweep", file, "--out", f"{folder}/out", "--backend", "cpu")
            self.assertEqual(done.returncode, 0, done.stderr)
            pd.testing.assert_frame_equal(pr.Result.load(f"{folder}/out").to_pandas(), rows, check_exact=True)
            loaded = pr.Study.load(file)
            pd.testing.assert_frame_equal(loaded.sweep("cpu", progress=False).to_pandas(), rows, check_exact=True)
            with self.assertRaisesRegex(ValueError, "the study is in this file already"):
                loaded.save(f"{folder}/other")
            pathlib.Path(file).write_text("seed = 8\n")
            with self.assertRaisesRegex(ValueError, r"study\.toml: is there already, and is another file"):
                test_labels.Cells().study(1).save(f"{folder}/saved")
            with self.assertRaisesRegex(ValueError, "lies outside of the study's folder"):
                box = {"name": "post", "role": "human", "box": {"size_m": [1, 1, 1]}, "position_m": [1, 1, 0.5]}
                study = pr.Study({**keys, "grid": {"voxel_size_m": 0.1}}, scenes={"../a": {"object": [box]}})
                study.save(f"{folder}/new")
            self.assertFalse(os.path.exists(f"{folder}/new"))


if __name__ == "__main__":
    unittest.main()
