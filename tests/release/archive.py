"""Packs a program as users download it, the same bytes for the same input: archive.py PROGRAM NOTICES NAME FOLDER

FOLDER gets NAME.tar.gz with the program, its licences, completions, manual pages, and all scenes, so that the commands of
the README work in it.
"""

import gzip
import io
import os
import pathlib
import subprocess
import sys
import tarfile
import tempfile

SHELLS = {
    "bash": "perirobot.bash",
    "elvish": "perirobot.elv",
    "fish": "perirobot.fish",
    "powershell": "_perirobot.ps1",
    "zsh": "_perirobot",
}
PAGES = ["README.md", "CHANGELOG.md", "CITATION.cff", "LICENSE-APACHE", "LICENSE-MIT"]


def output(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout


def contents(program, notices):
    """Bytes by path; the program is the one file that can be executed."""
    files = {program.name: program.read_bytes(), "LICENSE-THIRD-PARTY": notices.read_bytes()}
    scenes = output("git", "ls-files", "-z", "scenes").decode().split("\0")
    # The folder is also a crate.
    code = ["scenes/Cargo.toml", "scenes/lib.rs"]
    for path in [*PAGES, *(path for path in scenes if path and path not in code)]:
        files[path] = pathlib.Path(path).read_bytes()
    for shell, name in SHELLS.items():
        files[f"completions/{name}"] = output(program, "completions", shell)
    with tempfile.TemporaryDirectory() as folder:
        output(program, "man", folder)
        for page in pathlib.Path(folder).iterdir():
            files[f"man/{page.name}"] = page.read_bytes()
    return files


def main(program, notices, name, folder):
    program = pathlib.Path(program).resolve()
    date = int(os.environ["SOURCE_DATE_EPOCH"])
    path = pathlib.Path(folder) / f"{name}.tar.gz"
    with open(path, "wb") as file, gzip.GzipFile("", "wb", 9, file, mtime=0) as packed:
        with tarfile.open(fileobj=packed, mode="w", format=tarfile.GNU_FORMAT) as archive:
            for member, data in sorted(contents(program, pathlib.Path(notices)).items()):
                entry = tarfile.TarInfo(f"{name}/{member}")
                entry.size, entry.mtime = len(data), date
                entry.mode = 0o755 if member == program.name else 0o644
                archive.addfile(entry, io.BytesIO(data))


main(*sys.argv[1:])
