"""What the tests of the Python package share: where the project is, its command line, and its studies."""

import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).parents[2]

# Every study that ships, and a voxel size at which it takes seconds; None for its own.
STUDIES = {
    "approach.toml": None,
    "cheapest.toml": 0.1,
    "choose.toml": 0.1,
    "delivery.toml": None,
    "judge.toml": 0.1,
    "latching.toml": None,
    "quick.toml": 0.1,
    "sensors.toml": None,
    "tiny.toml": None,
    "palletiser/study.toml": 0.1,
    "tutorial/study.toml": 0.2,
    "paper/exp1-choose.toml": 0.25,
    "paper/exp1.toml": 0.25,
    "paper/exp2.toml": 0.25,
    "paper/exp3.toml": 0.25,
    "paper/lidar.toml": 0.25,
}

SCORES = ["f1", "kappa", "human_seen", "human_claimed", "unknown", "false_alarm", "seen_twice"]
# How pandas reads the table of results. A sensor may be called "NA", and only a score may be missing.
READ = {
    "keep_default_na": False,
    "na_values": {score: [""] for score in SCORES},
    "dtype": {score: float for score in SCORES},
}


def tiny_with_a_crumb(folder: str) -> pathlib.Path:
    """The tiny study in a cell with an object of a millimetre, of which the program warns."""
    copy = pathlib.Path(folder)
    (copy / "tiny").mkdir()
    cell = (ROOT / "scenes/tiny/cell.toml").read_text()
    crumb = '[[object]]\nname = "crumb"\nbox = { size_m = [0.001, 0.001, 0.001] }\nposition_m = [0, 0, 0.5]\n'
    (copy / "tiny/cell.toml").write_text(f"{cell}\n{crumb}")
    study = copy / "tiny.toml"
    study.write_text((ROOT / "scenes/tiny.toml").read_text())
    return study


def scenes(folder: str) -> pathlib.Path:
    """A copy of what ships in a folder, the paper's cameras with one pixel of 256, since most of the time goes into rays."""
    copy = pathlib.Path(folder) / "scenes"
    shutil.copytree(ROOT / "scenes", copy)
    for study in copy.glob("paper/*.toml"):
        study.write_text(study.read_text().replace("resolution_px = [1280, 720]", "resolution_px = [80, 45]"))
    return copy


def priced(folder: str, at_least: float) -> pathlib.Path:
    """The study of verdicts with an odd cost, and a requirement of this height."""
    study = scenes(folder) / "judge.toml"
    text = study.read_text().replace("cost = 450.0 ", "cost = 450.5 ")
    study.write_text(text.replace("at_least = 0.7", f"at_least = {at_least}"))
    return study


def program(*words: object) -> subprocess.CompletedProcess:
    """Runs the command `perirobot` that was installed with the package, in the project's folder."""
    command = [str(pathlib.Path(sys.executable).with_name("perirobot")), *map(str, words)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
