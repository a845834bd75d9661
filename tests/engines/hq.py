"""Stands in for HyperQueue's program `hq`, which its wheel does not have: those of its options that our script uses, and no
others, carried out by the real engine of the wheel. `hq.py server` is a server with one worker, until it is ended."""

import argparse
import os
import pathlib
import signal
import sys
import time

import hyperqueue
from hyperqueue.cluster import LocalCluster, WorkerConfig
from hyperqueue.ffi.protocol import ResourceRequest

FOLDER = pathlib.Path(os.environ["HQ_SERVER_DIR"])


def server():
    with LocalCluster(server_dir=str(FOLDER), worker_config=WorkerConfig(cores=4)):
        signal.signal(signal.SIGTERM, lambda number, frame: sys.exit())
        (FOLDER / "ready").touch()
        while True:
            time.sleep(3600)


def ids(text):
    """`0-2,5` as numbers."""
    for part in text.split(","):
        first, _, last = part.partition("-")
        yield from range(int(first), int(last or first) + 1)


def submit(options):
    """One task for each id; a task has the id of its place, so those between are left out afterwards."""
    assert (options.stdout, options.stderr) == ("none", "none"), "hq.py knows no other"
    job = hyperqueue.Job(max_fails=None, name=options.name, default_workdir=os.getcwd())
    for task_id in ids(options.array):
        task = job.program(
            options.command,
            stdout=None,
            stderr=None,
            resources=ResourceRequest(cpus=options.cpus),
            crash_limit=options.crash_limit,
        )
        task.task_id = task_id
    print(hyperqueue.Client(FOLDER).submit(job).id)


def wait(options):
    ended = hyperqueue.Client(FOLDER).connection.wait_for_jobs([options.job], lambda jobs: None)
    sys.exit(1 if ended else 0)


def task_ids(options):
    assert options.filter == "failed", "hq.py knows no other"
    failed = hyperqueue.Client(FOLDER).connection.get_failed_tasks([options.job])
    print(",".join(str(task_id) for task_id in sorted(failed.get(options.job, {}))))


def main():
    parser = argparse.ArgumentParser(allow_abbrev=False)
    verbs = parser.add_subparsers(required=True)
    verbs.add_parser("server").set_defaults(run=lambda options: server())

    verb = verbs.add_parser("submit", allow_abbrev=False)
    verb.add_argument("--output-mode", choices=["quiet"], required=True)
    verb.add_argument("--name", required=True)
    verb.add_argument("--array", required=True)
    verb.add_argument("--cpus", type=int, required=True)
    verb.add_argument("--crash-limit", type=int, required=True)
    verb.add_argument("--stdout", required=True)
    verb.add_argument("--stderr", required=True)
    verb.add_argument("command", nargs="+")
    verb.set_defaults(run=submit)

    verbs = verbs.add_parser("job").add_subparsers(required=True)
    verb = verbs.add_parser("wait", allow_abbrev=False)
    verb.add_argument("job", type=int)
    verb.set_defaults(run=wait)
    verb = verbs.add_parser("task-ids", allow_abbrev=False)
    verb.add_argument("job", type=int)
    verb.add_argument("--filter", required=True)
    verb.set_defaults(run=task_ids)

    options = parser.parse_args()
    options.run(options)


main()
