"""What looks at one choice of poses return: reasons, pictures, and ways to the robot."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING

from .answer import Answer
from .table import frame

if TYPE_CHECKING:
    import pandas

    from .study import Study


@dataclass(frozen=True)
class Why:
    """Why voxels stay unknown to a choice of poses at one moment; ``print`` shows it in words."""

    #: What ``perirobot why`` prints.
    text: str
    _csv: bytes

    def __str__(self) -> str:
        return self.text

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each region and reason, the columns of ``reasons.csv``. Needs pandas.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> rows = study.why("camera:right-wall/8/1").to_pandas()
        >>> rows.groupby("region").voxels_human.sum()
        """
        return frame(self._csv)


@dataclass(frozen=True)
class Picture:
    """A picture; notebooks show it."""

    #: The bytes of a PNG or an SVG file.
    data: bytes
    #: Which of them: "png" or "svg".
    kind: str

    def save(self, path: str | PathLike[str]) -> None:
        """Writes it into a file.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> study.render("camera:right-wall/8/1").save("pose.png")
        """
        with open(path, "wb") as file:
            file.write(self.data)

    def _repr_png_(self) -> bytes | None:
        return self.data if self.kind == "png" else None

    def _repr_svg_(self) -> str | None:
        return self.data.decode() if self.kind == "svg" else None


class Approach(Answer):
    """How near bodies come to the robot unnoticed: the answers, and the folder with the ways and floor plans."""

    _SHOWN = "approach.csv"

    def __init__(self, study: Study | None, folder: str | PathLike[str] | None) -> None:
        super().__init__(study, {}, folder)
        #: What ``perirobot approach`` prints.
        self.text = ""

    def __str__(self) -> str:
        return self.text

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each scene, snapshot, body and entry, the columns of ``approach.csv``. Needs pandas.

        >>> study = pr.Study.load("scenes/approach.toml")
        >>> study.approach("camera:wall/front").to_pandas().nlargest(1, "deepest_m")
        """
        return self._table("approach.csv")
