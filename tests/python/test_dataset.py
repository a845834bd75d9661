"""A data set has the labels and the truth of its study, whoever wrote which part, and however often it was stopped."""

import functools
import json
import multiprocessing
import os
import pathlib
import pickle
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
import warnings

import numpy as np

import perirobot as pr
from perirobot import dataset_inputs, dataset_writer
from shared import ROOT, tiny_with_a_crumb

SENSORS = {
    "seed": 3,
    "repeats": 2,
    "region": [
        {"name": "low", "box": {"min_m": [0, 0, 0], "max_m": [2, 1.6, 0.5]}},
        {"name": "all", "box": {"min_m": [0, 0, 0], "max_m": [2, 1.6, 1.2]}},
    ],
    "sensor": [
        {
            "name": "camera",
            "kind": "rgbd",
            "fov_deg": [87, 58],
            "resolution_px": [48, 32],
            "range_m": [0.1, 6],
            "dropout": 0.2,
            "poses": [{"name": "spot", "list": [{"position_m": [1, y, 1], "facing": [0, 1, -1]} for y in (0.3, 0.5, 0.7)]}],
        }
    ],
}


def cells(count: int = 7, seed: int = 1) -> dict[str, pr.Cell]:
    random = np.random.default_rng(seed)
    made = {}
    for number in range(count):
        occupied = random.random((20, 16, 12)) < 0.02
        person, robot = np.zeros((2, 20, 16, 12), bool)
        x = random.integers(2, 16)
        person[x : x + 2, 10:12, 1:10] = robot[9:11, 5:7, :6] = True
        made[f"cell {number}"] = pr.Cell(occupied, 0.1, people=person, robot=robot)
    return made


def slab(height_m: float) -> str:
    """A mesh of two triangles."""
    triangles = [[(0.2, 0.2), (1.8, 0.2), (1.8, 1.4)], [(0.2, 0.2), (1.8, 1.4), (0.2, 1.4)]]
    facets = ""
    for corners in triangles:
        vertices = "\n".join(f"vertex {x} {y} {height_m}" for x, y in corners)
        facets += f"facet normal 0 0 1\nouter loop\n{vertices}\nendloop\nendfacet\n"
    return f"solid slab\n{facets}endsolid slab\n"


def read(data: pr.Dataset, numbers: list[int], answers: "multiprocessing.Queue[int]") -> None:
    """What a worker of a data loader does."""
    for number in numbers:
        answers.put((number, int(data[number]["labels"].astype(int).sum())))


class Datasets(unittest.TestCase):
    def folder(self) -> str:
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder, True)
        return os.path.join(folder, "data")

    def files(self, folder: str) -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in sorted(pathlib.Path(folder).iterdir())}

    def equal(self, data: pr.Dataset, study: pr.Study, **words: object) -> None:
        """Each sample has the labels and the truth of the study, voxel by voxel."""
        number = 0
        for number, view in enumerate(study.each_labels(**words, backend="cpu", progress=False)):
            sample = data[number]
            self.assertEqual(data.sample(number), (view.scene, view.snapshot, view.repeat, view.poses))
            np.testing.assert_array_equal(data.origin_m(number), view.origin_m)
            truth = study.truth(view.scene, view.snapshot)
            expected = {"labels": view.labels, "hits": view.hits, "occupied": truth.occupied, "human": truth.human}
            expected |= {"robot": truth.robot, "regions": np.stack(list(truth.regions.values()))}
            self.assertEqual(list(sample), list(data.sheet["arrays"]))
            for name, array in sample.items():
                np.testing.assert_array_equal(array, expected[name], name)
                self.assertEqual(array.dtype, expected[name].dtype)
        self.assertEqual(len(data), number + 1)

    def test_samples_are_those_of_the_study(self):
        made, out = cells(), self.folder()
        data = pr.dataset(made, SENSORS, out=out, include=["occupied", "human", "robot", "regions", "hits"], cells_per_part=3)
        study = pr.Study(SENSORS, scenes=made)
        self.equal(data, study)
        # Noise of a cell depends on its number: parts must not change it.
        self.assertFalse(np.array_equal(data[0]["labels"], data[3]["labels"]), "there is no noise")
        self.assertEqual(len(data), 7 * 2 * 3)
        self.assertEqual([len(data), data.shape, data.sheet["parts"]], [42, (20, 16, 12), 3])
        labels = np.stack([sample["labels"] for sample in data])
        values = {"free": pr.FREE, "occupied": pr.OCCUPIED, "unknown": pr.UNKNOWN}
        self.assertEqual(data.counts, {name: int((labels == value).sum()) for name, value in values.items()})
        # Counted against the truth they are the counts of the sweep.
        frame = study.sweep("cpu", progress=False).to_pandas().query("region == 'low'").reset_index()
        for number, row in frame.iterrows():
            sample = data[number]
            inside, occupied = sample["regions"][0], sample["labels"] == pr.OCCUPIED
            self.assertEqual(row.tp, (inside & occupied & sample["occupied"]).sum())
            self.assertEqual(row.uf, (inside & (sample["labels"] == pr.UNKNOWN) & ~sample["occupied"]).sum())
        sheet = json.loads(pathlib.Path(out, "dataset.json").read_text())
        self.assertEqual(sheet["label_values"], values)
        [at] = sheet["placements"][1]
        np.testing.assert_array_equal([*at["position_m"], *at["quaternion_wxyz"]], study.poses("camera")[1][1])
        described = pathlib.Path(out, "README.md").read_text()
        for text in ["42 samples", "20 × 16 × 12 voxels", "| camera | rgbd | 3 | 1536 |", data.sha256, str(data.counts["free"])]:
            self.assertIn(text, described)
        # The files are usual ones.
        raw = np.load(os.path.join(out, "labels-00001.npy"))
        np.testing.assert_array_equal(raw[1, 1, 2], study.labels("camera:spot/2", scene="cell 4", repeat=1).labels.T)
        data.verify()

    def test_studies_that_ship_and_other_backends(self):
        study = pr.Study.load(ROOT / "scenes/sensors.toml")
        for combination in study.combinations:
            data = pr.dataset(study, combination=combination, out=self.folder(), backend="gpu", adapter="software")
            self.equal(data, study, combination=combination)
        tutorial = pr.Study.load(ROOT / "scenes/tutorial/study.toml", voxel_size_m=0.2)
        poses = tutorial._native.choices(0)[0][:2]
        data = pr.dataset(tutorial, poses=poses, combination=tutorial.combinations[0], include=[], out=self.folder())
        self.equal(data, tutorial, poses=poses, combination=tutorial.combinations[0])
        self.assertGreater(len({data.sample(n).snapshot for n in range(len(data))}), 1, "there are moments")

    def test_parts_are_the_same_whoever_writes_them(self):
        made, whole, shared = cells(), self.folder(), self.folder()
        data = pr.dataset(made, SENSORS, out=whole, cells_per_part=2)
        for number in (2, 0, 1):
            done = pr.dataset(made, SENSORS, out=shared, cells_per_part=2, shard=(number, 3), threads=1)
            self.assertEqual(len(done.missing), {2: 3, 0: 1, 1: 0}[number])
            if done.missing:
                with self.assertRaisesRegex(ValueError, f"{len(done.missing)} of 4 parts are missing: run perirobot.dataset"):
                    pr.open_dataset(shared)
        self.assertEqual(self.files(whole), self.files(shared))
        self.assertEqual(pr.open_dataset(shared).sha256, data.sha256)
        partial = self.folder()
        some = pr.dataset(made, SENSORS, out=partial, cells_per_part=2, shard=(1, 2))
        self.assertEqual([some.sample(0).scene, some.sample(len(some) - 1).scene], ["cell 2", "cell 6"])
        np.testing.assert_array_equal(some[0]["labels"], data[12]["labels"])

    def test_a_run_that_was_killed_goes_on(self):
        out, whole = self.folder(), self.folder()
        script = f"""
import sys; sys.path.insert(0, {str(ROOT / "tests/python")!r})
import os, perirobot as pr, perirobot.dataset_writer as writer
from test_dataset import SENSORS, cells
finish, done = writer._finish, []
def killed(path, *rest):
    if len(done) == 2: os.kill(os.getpid(), 9)
    done.append(path); finish(path, *rest)
writer._finish = killed
pr.dataset(cells(), SENSORS, out={out!r}, cells_per_part=2)
"""
        killed = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
        self.assertEqual(killed.returncode, -9, killed.stderr)
        left = sorted(os.listdir(out))
        self.assertIn("part-00001.json", left)
        self.assertNotIn("part-00002.json", left)
        stale = [name for name in left if name.endswith(".part")]
        self.assertTrue(stale, "it was killed while it wrote")
        for name in stale:
            os.utime(os.path.join(out, name), (0, 0))
        kept = os.stat(os.path.join(out, "labels-00000.npy")).st_mtime_ns
        pr.dataset(cells(), SENSORS, out=out)
        self.assertEqual(os.stat(os.path.join(out, "labels-00000.npy")).st_mtime_ns, kept, "a finished part is made again")
        pr.dataset(cells(), SENSORS, out=whole, cells_per_part=2)
        self.assertEqual(self.files(out), self.files(whole))
        # A file that is cut is made again; one that is altered is found.
        path = os.path.join(out, "human-00001.npy")
        with open(path, "r+b") as file:
            file.truncate(100)
        with self.assertRaisesRegex(ValueError, "1 of 4 parts are missing"):
            pr.open_dataset(out)
        data = pr.dataset(cells(), SENSORS, out=out)
        self.assertEqual(self.files(out), self.files(whole))
        with open(path, "r+b") as file:
            file.seek(200)
            file.write(b"\1")
        with self.assertRaisesRegex(ValueError, "human-00001.npy: differs from its hash"):
            data.verify()

    def test_a_slow_disk_gets_each_batch(self):
        made, study = cells(3), pr.Study(SENSORS, scenes=cells(3))
        write, batch = dataset_writer.ArrayFile.write, dataset_writer._BATCH_BYTES

        def slow(file: object, rows: np.ndarray) -> None:
            time.sleep(0.02)
            write(file, rows)

        self.addCleanup(setattr, dataset_writer.ArrayFile, "write", write)
        self.addCleanup(setattr, dataset_writer, "_BATCH_BYTES", batch)
        dataset_writer.ArrayFile.write, dataset_writer._BATCH_BYTES = slow, 2 * 20 * 16 * 12
        every = ["occupied", "human", "robot", "regions", "hits"]
        self.equal(pr.dataset(made, SENSORS, out=self.folder(), include=every), study)
        data = pr.dataset(made, SENSORS, out=self.folder(), include=[])
        for number, view in enumerate(study.each_labels(backend="cpu", progress=False)):
            np.testing.assert_array_equal(data[number]["labels"], view.labels)

    def test_ctrl_c_leaves_whole_parts_only(self):
        out = self.folder()

        class Stops:
            def __init__(self):
                self.calls = 0

            def begin(self, what, total):
                self.total = total

            def update(self, more):
                self.calls += 1
                raise KeyboardInterrupt

            def say(self, text):
                pass

        study = pr.Study(SENSORS, scenes=cells())
        job = dataset_writer._Job(study, out, ("cpu", None, None))
        job.prepare(None, None, None, ["human"], 2)
        bars = Stops()
        with self.assertRaises(KeyboardInterrupt):
            job.write(range(4), bars)
        self.assertEqual([bars.calls, bars.total], [1, 42])
        self.assertEqual(os.listdir(out), ["dataset.json"])

    def test_other_processes_read_it(self):
        data = pr.dataset(cells(), SENSORS, out=self.folder(), cells_per_part=2)
        expected = {number: int(sample["labels"].astype(int).sum()) for number, sample in enumerate(data)}
        self.assertTrue(data._maps)
        self.assertLess(len(pickle.dumps(data)), 20_000)
        again = pickle.loads(pickle.dumps(data))
        np.testing.assert_array_equal(again[-1]["human"], data[41]["human"])
        for way in ("fork", "spawn"):
            context = multiprocessing.get_context(way)
            answers = context.Queue()
            halves = [range(0, 42, 2), range(1, 42, 2)]
            with warnings.catch_warnings():
                # Of Python 3.12 and newer, about forks of processes with threads.
                warnings.simplefilter("ignore")
                workers = [context.Process(target=read, args=(data, list(half), answers)) for half in halves]
                for worker in workers:
                    worker.start()
            found = dict(answers.get(timeout=60) for _ in expected)
            for worker in workers:
                worker.join()
                self.assertEqual(worker.exitcode, 0)
            self.assertEqual(found, expected, way)

    def test_torch_reads_it(self):
        try:
            from torch.utils.data import DataLoader
        except ImportError:
            self.skipTest("torch is not installed")
        data = pr.dataset(cells(), SENSORS, out=self.folder(), cells_per_part=2)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            batches = list(DataLoader(data, batch_size=4, num_workers=2))
        self.assertEqual(tuple(batches[0]["labels"].shape), (4, 20, 16, 12))
        np.testing.assert_array_equal(batches[2]["regions"][1].numpy(), data[9]["regions"])

    def test_writing_into_samples_changes_no_file(self):
        out = self.folder()
        data = pr.dataset(cells(2), SENSORS, out=out)
        before = self.files(out)
        data[0]["labels"][:] = 7
        self.assertEqual(self.files(out), before)
        with self.assertRaises(IndexError):
            data[len(data)]
        with self.assertRaises(TypeError):
            data["labels"]

    def test_other_data_sets_are_refused(self):
        out, made = self.folder(), cells()
        pr.dataset(made, SENSORS, out=out, cells_per_part=2)
        before = self.files(out)
        other = {**SENSORS, "seed": 4}
        coarse = {**SENSORS, "sensor": [{**SENSORS["sensor"][0], "range_m": [0.1, 5]}]}
        fewer = dict(list(made.items())[:6])
        moved = {**made, "cell 6": cells(seed=2)["cell 6"]}
        for given, keys, words, message in [
            (made, other, {}, "other sensors, regions or keys"),
            (made, coarse, {}, "other sensors, regions or keys"),
            (fewer, SENSORS, {}, "other cells"),
            (moved, SENSORS, {}, "other cells"),
            (made, SENSORS, {"poses": ["camera:spot/1"]}, "other poses"),
            (made, SENSORS, {"include": ["human"]}, "other arrays"),
            (made, SENSORS, {"cells_per_part": 3}, "another number of cells_per_part"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, f"dataset.json: this data set has {message}: name"):
                pr.dataset(given, keys, out=out, **words)
        self.assertEqual(self.files(out), before)
        # Costs decide nothing.
        priced = {**SENSORS, "sensor": [{**SENSORS["sensor"][0], "cost": 5.0}]}
        pr.dataset(made, priced, out=out)
        foreign = self.folder()
        os.makedirs(foreign)
        pathlib.Path(foreign, "notes.txt").write_text("mine")
        with self.assertRaisesRegex(ValueError, "has 'notes.txt' and no dataset.json: name a new folder"):
            pr.dataset(made, SENSORS, out=foreign)
        self.assertEqual(os.listdir(foreign), ["notes.txt"])
        with self.assertRaisesRegex(ValueError, "dataset.json: is missing: name a folder that perirobot.dataset has written"):
            pr.open_dataset(foreign)

    def test_a_mesh_that_changes_meanwhile_is_refused(self):
        folder, out = tempfile.mkdtemp(), self.folder()
        self.addCleanup(shutil.rmtree, folder)
        shutil.copytree(ROOT / "scenes/paper", f"{folder}/paper")
        table = pathlib.Path(folder, "paper/scene1_operator.csv")
        grid = {"voxel_size_m": 0.2, "bounds_m": {"min": [-2, -2, 0.1], "max": [2, 2, 2.3]}}
        region = {"name": "all", "box": {"min_m": [-1.9, -1.9, 0], "max_m": [1.9, 1.9, 2.2]}}
        keys = {**SENSORS, "grid": grid, "region": [region]}
        scene = {"object": [{"name": "person", "mannequin": "paper/scene1_operator.csv"}]}
        given = {"a": scene, "b": scene}
        pr.dataset(given, keys, out=out, folder=folder, cells_per_part=1, shard=(0, 2))
        table.write_text(table.read_text().replace("\n1.", "\n1.0", 1) + "\n")
        with self.assertRaisesRegex(ValueError, "paper/scene1_operator.csv: has changed since .*part-00000.json was written"):
            pr.dataset(given, keys, out=out, folder=folder)

    def test_files_that_changed_afterwards_are_refused(self):
        folder, out = pathlib.Path(tempfile.mkdtemp()), self.folder()
        self.addCleanup(shutil.rmtree, folder)
        for name in ("one", "two"):
            (folder / f"{name}.stl").write_text(slab(0.3))
        keys = {**SENSORS, "grid": {"voxel_size_m": 0.1, "bounds_m": {"min": [0.05] * 3, "max": [1.95, 1.55, 1.15]}}}
        mesh = {"name": "slab", "unit": "m"}
        given = {name: {"object": [{**mesh, "mesh": f"{name}.stl"}]} for name in ("one", "two")}
        words = {"out": out, "folder": folder, "cells_per_part": 1}
        study = pr.Study(keys, scenes=given, folder=folder)
        study.truth()
        data = pr.dataset(given, keys, **words)
        before, one = self.files(out), folder / "one.stl"
        dates = os.stat(one)

        def change(to: str) -> None:
            one.write_text(to)
            os.utime(one, ns=(dates.st_atime_ns, dates.st_mtime_ns))
            self.assertEqual((os.stat(one).st_size, os.stat(one).st_mtime_ns), (dates.st_size, dates.st_mtime_ns))

        change(slab(0.4))
        refused = "^one.stl: has changed since .*part-00000.json was written: put the earlier file back, or name another folder for out"
        for name, resumed in {
            "it is complete": lambda: pr.dataset(given, keys, **words),
            "the scenes are in voxels already": lambda: pr.dataset(study, out=out),
            "only the other part is written": lambda: pr.dataset(given, keys, **words, shard=(1, 2)),
        }.items():
            with self.subTest(name), self.assertRaisesRegex(ValueError, refused):
                resumed()
        self.assertEqual(self.files(out), before)
        self.assertEqual(pr.open_dataset(out).sha256, data.sha256)
        # The part that is made again does not read this file.
        os.remove(os.path.join(out, "part-00001.json"))
        with self.assertRaisesRegex(ValueError, refused):
            pr.dataset(given, keys, **words)
        one.unlink()
        with self.assertRaisesRegex(ValueError, "one.stl"):
            pr.dataset(given, keys, **words)
        with self.assertRaisesRegex(ValueError, "^one.stl: is missing, but was there when .*part-00000.json was written: put it back"):
            pr.dataset(study, out=out)
        change(slab(0.3))
        self.assertEqual(pr.dataset(given, keys, **words).sha256, data.sha256)
        self.assertEqual(self.files(out), before)
        # Into another folder, a study that read the earlier file writes nothing.
        change(slab(0.4))
        with self.assertRaisesRegex(ValueError, "^one.stl: has changed since the study read it: make the study again"):
            pr.dataset(study, out=self.folder())

    def test_files_of_packages_and_elsewhere_are_found_again(self):
        folder, parts = pathlib.Path(tempfile.mkdtemp()), pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, folder)
        self.addCleanup(shutil.rmtree, parts)
        path, mesh = tiny_with_a_crumb(str(folder)), parts / "slab.stl"
        cell = path.parent / "tiny/cell.toml"
        cell.write_text(f'{cell.read_text()}\n[[object]]\nname = "slab"\nmesh = "{mesh}"\nunit = "m"\n')
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pr.InputWarning)
            for words, name in [({"packages": {"parts": parts}}, "package://parts/slab.stl"), ({"allow_outside": True}, str(mesh))]:
                out = self.folder()
                for height_m, fails in [(0.3, False), (0.3, False), (0.4, True)]:
                    mesh.write_text(slab(height_m))
                    study = pr.Study.load(path, **words)
                    make = functools.partial(pr.dataset, study, combination=study.combinations[0], out=out)
                    if fails:
                        with self.assertRaisesRegex(ValueError, f"^{name}: has changed since .*part-00000.json was written"):
                            make()
                    else:
                        self.assertIn(name, json.loads(pathlib.Path(make().folder, "part-00000.json").read_text())["read"])

    def test_comments_of_files_change_nothing(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        path = tiny_with_a_crumb(folder)
        out, words = self.folder(), {"combination": pr.Study.load(path).combinations[0]}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pr.InputWarning)
            data = pr.dataset(pr.Study.load(path), out=out, **words)
            for file in (path, path.parent / "tiny/cell.toml"):
                file.write_text(f"# Ours.\n{file.read_text()}")
            self.assertEqual(pr.dataset(pr.Study.load(path), out=out, **words).sha256, data.sha256)
            file.write_text(file.read_text().replace("[0, 0, 0.5]", "[0, 0, 0.6]"))
            with self.assertRaisesRegex(ValueError, "dataset.json: this data set has other cells: name"):
                pr.dataset(pr.Study.load(path), out=out, **words)

    def test_what_is_wrong_is_named(self):
        made = cells(3)
        person = np.zeros((20, 16, 11), bool)
        person[5, 5, :] = True
        bare = {name: keys for name, keys in SENSORS.items() if name != "sensor"}
        for given, keys, words, message in [
            ({}, SENSORS, {}, "cells: there is none"),
            ([], SENSORS, {}, "cells: there is none"),
            (5, SENSORS, {}, "cells = 5: must be cells by their names"),
            (made, None, {}, "sensors: name the keys of a study"),
            (made, bare, {}, "sensor"),
            (pr.Study(SENSORS, scenes=made), SENSORS, {}, "sensors: belong to cells"),
            ({**made, "low": pr.Cell(person, 0.1)}, SENSORS, {}, r"cells\['low'\]: has \(20, 16, 11\) voxels, 'cell 0' has"),
            (made, SENSORS, {"shard": (3, 3)}, r"shard = \(3, 3\): must be \(k, n\), with k from 0 to n - 1"),
            (made, SENSORS, {"shard": 2}, r"shard = 2: must be \(k, n\)"),
            (made, SENSORS, {"shard": (0, 2)}, r"shard = \(0, 2\): the data set has 1 parts: use at most 1"),
            (made, SENSORS, {"cells_per_part": 0}, "cells_per_part = 0: must be at least 1"),
            (made, SENSORS, {"include": ["truth"]}, "include: 'truth' must be one of"),
            (made, SENSORS, {"poses": []}, "poses: name at least one"),
            (made, SENSORS, {"poses": ["camera:spot/9"]}, "camera:spot/9"),
            (made, SENSORS, {"combination": "lidar"}, "combination = 'lidar': must be one of"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                pr.dataset(given, keys, out=self.folder(), **words)
        # Scenes of any size need bounds.
        boxes = {
            name: {"object": [{"name": "box", "box": {"size_m": [size, 1, 1]}, "position_m": [0.5, 0.5, 0.5]}]}
            for name, size in (("a", 1), ("b", 3))
        }
        keys = {**SENSORS, "grid": {"voxel_size_m": 0.1}}
        with self.assertRaisesRegex(ValueError, "scene 'b': has .* voxels, others have .*: set bounds_m of"):
            pr.dataset(boxes, keys, out=self.folder())
        keys["grid"]["bounds_m"] = {"min": [-1, -1, 0.05], "max": [2, 2, 1.95]}
        self.assertEqual(len(pr.dataset(boxes, keys, out=self.folder())), 12)

    def test_folders_that_take_no_files(self):
        file = pathlib.Path(self.folder()).parent / "file"
        file.write_text("")
        with self.assertRaisesRegex(ValueError, "is a file: name a folder for the data set"):
            pr.dataset(cells(2), SENSORS, out=file)
        with self.assertRaises(OSError):
            pr.dataset(cells(2), SENSORS, out=file / "below")
        with self.assertRaises(OSError):
            pr.dataset(cells(2), SENSORS, out="/proc/nowhere")

    def test_warnings_come_once_and_are_kept(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        study = pr.Study.load(tiny_with_a_crumb(folder))
        out = self.folder()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            pr.dataset(study, combination=study.combinations[0], out=out)
        self.assertEqual([warning.category for warning in caught], [pr.InputWarning])
        self.assertEqual(caught[0].filename, __file__)
        part = json.loads(pathlib.Path(out, "part-00000.json").read_text())
        self.assertIn("crumb", json.dumps(part["warnings"]))


class DerivedNames(unittest.TestCase):
    def test_what_programs_made_of_a_file_is_no_file(self):
        derived = (
            "robot.xacro (expanded)",
            "plant.step (converted)",
            'plant.step (converted, not on layer "Fence (left)")',
        )
        for name in derived:
            self.assertTrue(dataset_inputs._DERIVED.search(name), name)
        for name in ("plant.step", "plant (converted).stl"):
            self.assertFalse(dataset_inputs._DERIVED.search(name), name)


if __name__ == "__main__":
    unittest.main()
