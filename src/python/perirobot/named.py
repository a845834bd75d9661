"""What a study has, by name."""

from __future__ import annotations

from . import _perirobot


class Named:
    """The names of what a study has, and its numbers."""

    _native: _perirobot.Study

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

    @property
    def sensors(self) -> list[str]:
        """Names of the sensors that take poses."""
        return self._native.sensors

    def _sensor(self, name: str | None) -> str:
        known = self.sensors
        if name is None and len(known) != 1:
            raise ValueError(f"sensor: say which of {known}")
        return known[0] if name is None else name
