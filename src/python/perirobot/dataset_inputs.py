"""The files that a data set is made from. Parts that were made from different contents of a file do not belong together."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from . import _perirobot
from .samples import file_sha256, part_name

if TYPE_CHECKING:
    from .study import Study

#: Ends of names in the list of files that are not files: programs made their contents of the file that the name begins with.
_DERIVED = re.compile(r" \((expanded|converted).*\)$")


class Inputs:
    """The files that the study and the finished parts have read, by their names from the study's folder."""

    def __init__(self, study: Study, out: str) -> None:
        self._study, self._out = study, out
        #: Hash of each file, and what has read it.
        self._known: dict[str, tuple[str, str]] = {}

    def add_part(self, read: Mapping[str, str], number: int) -> None:
        """Takes the files of a part; fails if one differs from what an earlier part was made from."""
        for name, sha256 in read.items():
            before, path = self._known.setdefault(name, (sha256, os.path.join(self._out, part_name(number))))
            if before != sha256:
                raise _changed(name, f"{path} was written")

    def study_files(self) -> dict[str, str]:
        """The files that the study has read so far, with their hashes."""
        return dict(_perirobot.disk_files(self._study._native))

    def check(self) -> None:
        """Reads all these files again; fails if one is missing or has changed, whatever its size and date."""
        read = {name: (sha256, "") for name, sha256 in self.study_files().items()}
        for name, (sha256, path) in self._known.items():
            if read.get(name, (sha256, ""))[0] != sha256:
                raise _changed(name, f"{path} was written")
        for name, (sha256, path) in {**read, **self._known}.items():
            if _DERIVED.search(name):
                continue
            since = f"{path} was written" if path else "the study read it"
            try:
                now = file_sha256(self._place(name))
            except FileNotFoundError:
                raise ValueError(f"{name}: is missing, but was there when {since}: put it back{_OTHERWISE}") from None
            if now != sha256:
                raise _changed(name, since) if path else ValueError(f"{name}: has changed since {since}: make the study again")

    def _place(self, name: str) -> str:
        """The path of a file in the list."""
        kind, words = self._study._origin
        if kind == "from_keys":
            return os.path.join(words[1], name)
        for package, folder in words[3]:
            prefix = f"package://{package}/"
            if name.startswith(prefix):
                return os.path.join(folder, name[len(prefix) :])
        return os.path.join(os.path.dirname(words[0]), name)


#: What else to do about a file that is not as it was.
_OTHERWISE = ", or name another folder for out; perirobot.open_dataset reads what is finished"


def _changed(name: str, since: str) -> ValueError:
    return ValueError(f"{name}: has changed since {since}: put the earlier file back{_OTHERWISE}")
