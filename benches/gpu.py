"""What each kernel takes on a GPU, in the experiments of the paper: python3 benches/gpu.py PROGRAM [ARGUMENT...].

PROGRAM is a release build of perirobot; the arguments go on to `sweep` (`--adapter 1`, `--as-gpu`). Each experiment is swept twice,
and the second run counts: the driver has compiled the kernels by then. Prints a table for `src/guide/wide_gpus.md`, and entries for
`benches/results.toml`.

Without a GPU: python3 benches/gpu.py compare PROGRAM [ARGUMENT...] -- PROGRAM [ARGUMENT...]

Sweeps two experiments once with each program, and prints a table of the dispatches and lanes of their kernels, before and after.
"""

import re
import subprocess
import sys
import tempfile
import time

EXPERIMENTS = [
    ("scenes/paper/exp1.toml", "0.05"),
    ("scenes/paper/exp1.toml", "0.02"),
    ("scenes/paper/exp1.toml", "0.01"),
    ("scenes/paper/exp3.toml", "0.02"),
]
COMPARED = [("scenes/paper/exp1.toml", "0.05"), ("scenes/paper/exp3.toml", "0.05")]
STAGE = re.compile(r"^ *(\w+) +([\d.]+) ms +(\d+) dispatches of ([\d.]+) rows, (\d+) lanes$", re.M)
ENTRY = """
[[run]]
table = "kernels"
column = "{column}"
unit = "ms"
runs = 1
machine = "MACHINE"
commit = "COMMIT"
date = "{date}"
command = "{command}"
values = {{ {values} }}"""


def sweep(program: str, study: str, size: str, more: list[str], times: int = 2) -> tuple[list[str], str, float]:
    """The arguments of a sweep, what it printed, and how long the last of some took in seconds."""
    words = ["sweep", study, "--voxel-size", size, "--backend", "gpu", "--timings", "--verify", "0", *more]
    for _ in range(times):
        with tempfile.TemporaryDirectory() as out:
            begin = time.perf_counter()
            told = subprocess.run([program, *words, "--out", out], check=True, capture_output=True, text=True)
            seconds = time.perf_counter() - begin
    return words, told.stderr + told.stdout, seconds


def name_of(study: str, size: str) -> str:
    """What a table calls an experiment."""
    return f"{study.removesuffix('.toml')}, {100 * float(size):g} cm"


def compare(before: list[str], after: list[str]) -> None:
    """The dispatches and lanes of two programs, each with its arguments, in a table."""
    print("| experiment | kernel | dispatches | after | lanes, millions | after |")
    print("|---|---|---:|---:|---:|---:|")
    for study, size in COMPARED:
        told = [sweep(program, study, size, more, 1)[1] for program, *more in (before, after)]
        old, new = ({stage: (dispatches, int(lanes) / 1e6) for stage, _, dispatches, _, lanes in STAGE.findall(text)} for text in told)
        for stage in [*old, *(stage for stage in new if stage not in old)]:
            (a, b), (c, d) = (some.get(stage, ("0", 0.0)) for some in (old, new))
            print(f"| {name_of(study, size)} | `{stage}` | {a} | {c} | {b:.1f} | {d:.1f} |", flush=True)


def main(program: str, more: list[str]) -> None:
    entries = []
    print("| experiment | kernel | time | a scene-pose | dispatches | rows of one | lanes |")
    print("|---|---|---:|---:|---:|---:|---:|")
    for study, size in EXPERIMENTS:
        words, told, seconds = sweep(program, study, size, more)
        poses = int(re.search(r"^(\d+) scene-poses in ", told, re.M)[1])
        stages = STAGE.findall(told)
        name = name_of(study, size)
        whole = sum(float(ms) for _, ms, *_ in stages)
        print(f"| {name} | the command | {seconds:.1f} s | {1e6 * seconds / poses:.0f} µs | | | |")
        print(f"| {name} | all kernels | {whole:.0f} ms | {1e3 * whole / poses:.1f} µs | | | |")
        for stage, ms, dispatches, rows, lanes in stages:
            each = 1e3 * float(ms) / poses
            print(f"| {name} | `{stage}` | {ms} ms | {each:.1f} µs | {dispatches} | {rows} | {lanes} |")
        values = ["all = %.0f" % whole, *(f'"`{stage}`" = {float(ms):.0f}' for stage, ms, *_ in stages)]
        command, date = " ".join(["perirobot", *words]), time.strftime("%Y-%m-%d")
        entries.append(ENTRY.format(column=name, date=date, command=command, values=", ".join(values)))
    print("\n".join(entries))


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if sys.argv[1] == "compare" and "--" in sys.argv:
        at = sys.argv.index("--")
        compare(sys.argv[2:at], sys.argv[at + 1 :])
    else:
        main(sys.argv[1], sys.argv[2:])
