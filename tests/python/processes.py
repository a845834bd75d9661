"""Jobs in other processes, each started from a process that has counted already: `python processes.py WAY BACKEND`.

It ends with code 0 if the other processes count the same. `test_processes.py` runs it and ends it if it hangs.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import time
import warnings
from typing import Any

import numpy as np

import perirobot as pr
from shared import ROOT


def counted(study: pr.Study, words: dict[str, str]) -> list[np.ndarray]:
    """What each kind of job gives: a sweep, counts of poses, labels."""
    poses = study.poses("camera")[1]
    labels = study.labels("lidar:posts/upright", **words)
    columns = study.sweep(**words, progress=False).columns
    return [columns["tp"], columns["uf"], study.evaluate(poses, "camera", **words), labels.labels]


def same(ours: list[np.ndarray], theirs: list[np.ndarray]) -> bool:
    return all(np.array_equal(one, other) for one, other in zip(ours, theirs))


def in_child(job: Any) -> int:
    """The exit code of a job in a forked child, which ends as scripts end: all of its objects are dropped."""
    child = os.fork()
    if child == 0:
        sys.exit(0 if job() else 1)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def fork(study: pr.Study, words: dict[str, str]) -> None:
    before = counted(study, words)
    fresh = pr.Study.load(ROOT / "scenes/tiny.toml")

    def job() -> bool:
        again = [same(before, counted(one, words)) for one in (study, fresh)]
        return all(again) and in_child(lambda: same(before, counted(study, words))) == 0

    assert in_child(job) == 0
    assert same(before, counted(study, words)), "the parent goes on"
    assert in_child(job) == 0, "a second child"


def fork_while_counting(study: pr.Study, words: dict[str, str]) -> None:
    """Another thread counts meanwhile, with the same study."""
    before, is_over = counted(study, words), threading.Event()

    def work() -> None:
        while not is_over.is_set():
            counted(study, words)

    thread = threading.Thread(target=work)
    thread.start()
    for _ in range(3):
        time.sleep(0.05)
        assert in_child(lambda: same(before, counted(study, words))) == 0
    is_over.set()
    thread.join()


def interrupt(study: pr.Study, words: dict[str, str]) -> None:
    """Ctrl-C ends a child that counts, too."""
    counted(study, words)
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            while True:
                study.sweep(**words, progress=False)
        except KeyboardInterrupt:
            os._exit(7)
    time.sleep(0.5)
    os.kill(child, signal.SIGINT)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7


def pool(way: str, study: pr.Study, words: dict[str, str]) -> None:
    before = counted(study, words)
    with multiprocessing.get_context(way).Pool(2) as workers:
        for theirs in workers.starmap(counted, [(study, words)] * 3):
            assert same(before, theirs)


class Dataset:
    """As torch's data loaders read one: moments and poses by number."""

    def __init__(self, study: pr.Study, words: dict[str, str]) -> None:
        self.study, self.words = study, words
        self.names = study.poses("camera")[0]

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, number: int) -> np.ndarray:
        return self.study.labels(f"camera:{self.names[number]}", **self.words).labels.copy()


def load(dataset: Dataset, asked: Any, answers: Any) -> None:
    """The loop of a worker of torch's data loaders."""
    for number in iter(asked.get, None):
        answers.put((number, dataset[number]))


def loader(way: str, study: pr.Study, words: dict[str, str]) -> None:
    """What torch's `DataLoader(dataset, num_workers=2, multiprocessing_context=way)` does, without torch."""
    dataset, context = Dataset(study, words), multiprocessing.get_context(way)
    before = [dataset[number] for number in range(len(dataset))]
    queues = [(context.Queue(), context.Queue()) for _ in range(2)]
    workers = [context.Process(target=load, args=(dataset, *of_one), daemon=True) for of_one in queues]
    for worker in workers:
        worker.start()
    for epoch in range(2):
        for number in range(len(dataset)):
            queues[number % 2][0].put(number)
        for number in range(len(dataset)):
            found, labels = queues[number % 2][1].get()
            assert found == number and np.array_equal(labels, before[number]), epoch
    for (asked, _), worker in zip(queues, workers):
        asked.put(None)
        worker.join()
        assert worker.exitcode == 0


def torch(study: pr.Study, words: dict[str, str]) -> None:
    from torch.utils.data import DataLoader

    dataset = Dataset(study, words)
    before = [dataset[number] for number in range(len(dataset))]
    for labels, expected in zip(DataLoader(dataset, num_workers=2, batch_size=None), before):
        assert np.array_equal(np.asarray(labels), expected)


def gymnasium(study: pr.Study, words: dict[str, str]) -> None:
    """An environment whose action is a pose and whose reward is a count, in processes of its own."""
    import gymnasium

    poses = study.poses("camera")[1]
    expected = study.evaluate(poses, "camera", **words)[:, 0, 0, 0, 0, 0]

    class Cell(gymnasium.Env):
        observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (7,), np.float64)
        action_space = gymnasium.spaces.Discrete(len(poses))

        def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
            return poses[0], {}

        def step(self, action: int) -> Any:
            tp = study.evaluate(poses[action], "camera", **words)[0, 0, 0, 0, 0, 0]
            return poses[action], float(tp), False, False, {}

    environments = gymnasium.vector.AsyncVectorEnv([Cell, Cell])
    environments.reset(seed=1)
    for action in range(len(poses)):
        rewards = environments.step(np.array([action, 0]))[1]
        assert rewards.tolist() == [expected[action], expected[0]], rewards
    environments.close()


WAYS = {
    "fork": fork,
    "fork while counting": fork_while_counting,
    "interrupt": interrupt,
    **{f"pool {way}": lambda *words, way=way: pool(way, *words) for way in ("fork", "spawn", "forkserver")},
    **{f"loader {way}": lambda *words, way=way: loader(way, *words) for way in ("fork", "spawn", "forkserver")},
    "torch": torch,
    "gymnasium": gymnasium,
}

if __name__ == "__main__":
    warnings.simplefilter("ignore")
    backend = {"backend": sys.argv[2]} | ({"adapter": "software"} if sys.argv[2] == "gpu" else {})
    WAYS[sys.argv[1]](pr.Study.load(ROOT / "scenes/tiny.toml"), backend)
