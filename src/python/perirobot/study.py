"""A study: scenes, regions, sensors and their candidate poses."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike

from . import _perirobot
from .progress import shown
from .result import Result


class Study:
    """A checked study. Make one with :meth:`load`.

    Its scenes are put into voxels when they are first needed, and kept.
    """

    def __init__(self, native: _perirobot.Study) -> None:
        self._native = native

    @classmethod
    def load(
        cls,
        path: str | PathLike[str],
        *,
        voxel_size_m: float | None = None,
        noiseless: bool = False,
        packages: Mapping[str, str | PathLike[str]] | None = None,
        allow_outside: bool = False,
    ) -> Study:
        """Reads and checks a study file (TOML) and the scene files that it names.

        :param path: the study file; the files that it names lie in its folder or below.
        :param voxel_size_m: edge of a voxel in metres, instead of the study's.
        :param noiseless: ideal sensors: no noise, no lost returns, no error of the mount.
        :param packages: folders of ROS packages by their names, for the meshes of robots.
        :param allow_outside: read files from other folders, too.
        :raises ValueError: what is wrong, by file and key.
        """
        named = list((packages or {}).items())
        return cls(_perirobot.Study.load(path, voxel_size_m, noiseless, named, allow_outside))

    @property
    def voxel_size_m(self) -> float:
        """Edge of a voxel in metres."""
        return self._native.voxel_size_m

    @property
    def repeats(self) -> int:
        """How often everything is scored, each time with other noise."""
        return self._native.repeats

    @property
    def scenes(self) -> list[str]:
        """Names of the scenes."""
        return [name for name, _ in self._native.scenes]

    @property
    def regions(self) -> list[str]:
        """Names of the regions in which voxels are counted."""
        return self._native.regions

    @property
    def combinations(self) -> list[str]:
        """Names of the combinations: sensors that are scored together, or each sensor alone."""
        return self._native.combinations

    def sweep(
        self,
        backend: str = "auto",
        *,
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
    ) -> Result:
        """Scores every choice of poses of every combination, in every snapshot of every scene, all in memory.

        The interpreter's lock is released meanwhile, and Ctrl-C stops the sweep after the batch under way.

        :param backend: "auto" (a hardware GPU if there is one, else the CPU), "cpu", "gpu" or "oracle"; all count the same.
        :param adapter: a Vulkan adapter for the GPU: its number, a part of its name, or "software".
        :param threads: threads of the CPU; all by default.
        :param progress: whether to show a bar, where tqdm is installed.
        :raises ValueError: what is wrong with scenes, meshes or arguments.
        :raises RuntimeError: if the device fails.
        """
        with shown(self._native.jobs, "poses", progress) as update:
            columns = self._native.sweep((backend, adapter, threads), update)
        return Result(self._native, columns)
