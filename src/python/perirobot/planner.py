"""The planner: a study opened as a page in which sensors are placed by hand."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request
from html import escape
from os import PathLike
from types import TracebackType
from typing import Any, Optional

from .study import Study

#: How long the planner may take to answer, in seconds: scenes become voxels before it does.
_PATIENCE_S = 600.0


#: How a study file is read: edge of a voxel, without noise, packages, files elsewhere, xacro, STEP.
_Options = tuple[Optional[float], bool, list[tuple[str, str]], bool, bool, bool]


def _flags(options: _Options) -> list[str]:
    """The same for the command line."""
    voxel_size_m, noiseless, packages, allow_outside, xacro, step = options
    flags = [] if voxel_size_m is None else ["--voxel-size", str(voxel_size_m)]
    flags += ["--noiseless"] * noiseless + ["--allow-outside"] * allow_outside + ["--xacro"] * xacro
    flags += ["--step"] * step
    for name, folder in packages:
        flags += ["--package", f"{name}={folder}"]
    return flags


class Planner:
    """A planner that runs; made by :func:`plan`.

    In a notebook it is a link to its page. Use it with ``with``, or call :meth:`close`.
    """

    def __init__(
        self, path: str, words: list[str], read: _Options, folder: tempfile.TemporaryDirectory[str] | None
    ) -> None:
        self._path = path
        self._read = read
        self._folder = folder
        command = [sys.executable, "-m", "perirobot", "plan", path, *words]
        # A file, as nobody reads a pipe while the planner runs.
        self._said = tempfile.TemporaryFile()
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self._said, text=True)
        assert self._process.stdout is not None
        begin = "http://127.0.0.1:"
        said, found, rest = self._process.stdout.readline().partition(begin)
        if not found:
            self._process.communicate()
            self._said.seek(0)
            error = self._said.read().decode(errors="replace").strip()
            self._said.close()
            raise ValueError(error.partition("error: ")[2] or error or said)
        #: The address of the page, with the secret that lets it in.
        self.url: str = begin + rest.strip()
        base, _, self._token = self.url.partition("#")
        self._base = base.rstrip("/")

    def study(self) -> Study:
        """The study as it is on the page now, saved or not.

        >>> with pr.plan("scenes/tiny.toml", open_browser=False) as planner:
        ...     scenes = planner.study().scenes

        :raises ValueError: what is wrong with it, by key.
        :raises RuntimeError: if the planner has ended.
        """
        answer = self._ask("/text")
        texts = [(os.path.basename(self._path), answer["text"]), *answer["scenes"].items()]
        return Study._read(self._path, *self._read, texts)

    def is_changed(self) -> bool:
        """Whether there are changes that were not saved.

        >>> with pr.plan("scenes/tiny.toml", open_browser=False) as planner:
        ...     changed = planner.is_changed()
        """
        return bool(self._ask("/state")["changed"])

    def close(self) -> None:
        """Ends the planner. Changes that were not saved are lost; take :meth:`study` before.

        >>> planner = pr.plan("scenes/tiny.toml", open_browser=False)
        >>> planner.close()
        """
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGTERM)
        self._process.communicate()
        self._said.close()
        if self._folder is not None:
            self._folder.cleanup()

    def _ask(self, path: str) -> Any:
        request = urllib.request.Request(self._base + path, headers={"X-Perirobot-Token": self._token})
        try:
            with urllib.request.urlopen(request, timeout=_PATIENCE_S) as answer:
                return json.load(answer)
        except urllib.error.URLError as error:
            raise RuntimeError(f"{self._path}: the planner does not answer: {error}") from None

    def __enter__(self) -> Planner:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Planner({self._path!r}, {self.url!r})"

    def _repr_html_(self) -> str:
        return f'<a href="{escape(self.url)}" target="_blank" rel="noreferrer">Plan {escape(self._path)}</a>'


def plan(
    study: str | PathLike[str] | Study,
    *,
    open_browser: bool | None = None,
    read_only: bool = False,
    port: int = 0,
) -> Planner:
    """Opens a study in the planner, a page in which sensors are placed by hand, and returns at once.

    >>> with pr.plan("scenes/tiny.toml", open_browser=False) as planner:
    ...     result = planner.study().sweep()

    :param study: a study file, or a study. One that was made of objects is saved into a temporary folder first, which
        :meth:`Planner.close` removes.
    :param open_browser: whether the page is opened; default: not in a notebook, where the planner is a link.
    :param read_only: whether the study file is never written.
    :param port: the port on 127.0.0.1; 0 takes any that is free.
    :raises ValueError: if the file cannot be read, or another planner has it open.
    """
    folder = None
    read: _Options = (None, False, [], False, False, False)
    if isinstance(study, Study):
        kind, (first, *rest) = study._origin
        if kind == "load":
            path = str(first)
            *options, texts = rest
            if texts:
                raise ValueError(f"{path}: the study has changes that are not in its file: save them in the planner first")
            read = (options[0], options[1], options[2], options[3], options[4], options[5])
        else:
            folder = tempfile.TemporaryDirectory(prefix="perirobot-")
            path = study.save(folder.name)
    else:
        path = os.fspath(study)
    if open_browser is None:
        open_browser = "ipykernel" not in sys.modules
    words = ["--port", str(port), *_flags(read)]
    words += [] if open_browser else ["--no-open"]
    words += ["--read-only"] if read_only else []
    try:
        return Planner(path, words, read, folder)
    except BaseException:
        if folder is not None:
            folder.cleanup()
        raise
