"""Writes the licence texts of all crates in the program and the Python package to a file: notices.py FILE TARGET"""

import json
import pathlib
import re
import subprocess
import sys

# Spellings of a licence file's name.
NAME = re.compile(r"(licen[cs]e|copying|notice|unlicense)", re.IGNORECASE)


def main(out, target):
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", target]
    metadata = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    # What is compiled in: dependencies that are neither for tests nor for build scripts.
    todo = [p for p in packages.values() if p["name"] == "perirobot-python"]
    linked = {}
    while todo:
        package = todo.pop()
        if linked.setdefault(package["id"], package) is not package or package["id"] not in nodes:
            continue
        for dependency in nodes[package["id"]]["deps"]:
            kinds = [kind["kind"] for kind in dependency["dep_kinds"]]
            if None in kinds and dependency["pkg"] not in linked:
                todo.append(packages[dependency["pkg"]])
    texts = {}
    for package in linked.values():
        if package["source"] is None:
            continue
        folder = pathlib.Path(package["manifest_path"]).parent
        name = f"{package['name']} {package['version']} ({package['license']})"
        files = sorted(p for p in folder.iterdir() if p.is_file() and NAME.match(p.name))
        if not files:
            texts.setdefault("The package contains only the name of its licence.", []).append(name)
        for file in files:
            text = file.read_text(encoding="utf-8", errors="replace").replace("\r\n", "\n").strip()
            texts.setdefault(text, []).append(name)
    line = "=" * 80
    parts = ["Licences of the Rust crates that are compiled into perirobot."]
    for text, names in sorted(texts.items(), key=lambda item: sorted(set(item[1]))):
        parts.append("\n".join([line, *sorted(set(names)), line, text]))
    pathlib.Path(out).write_text("\n\n".join(parts) + "\n", encoding="utf-8")


main(*sys.argv[1:])
