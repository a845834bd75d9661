"""What is said and drawn of one choice of poses: the commands ``why``, ``approach``, ``export``, ``render``, ``judge``
and ``report`` as methods."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

from . import _perirobot
from .answer import Answer
from .best import Best
from .checks import index, needed, texts, three
from .device import Backend, words
from .findings import Approach, Picture, Why
from .progress import shown
from .purchase import Purchase

if TYPE_CHECKING:
    import pandas

    from .study import Study


class Looks:
    """The methods of a study that look at one choice of poses closely.

    All take its name as in the column ``poses`` of the results, "camera:right-wall/8/1"; poses joined by ";" are a set, whether
    the study lists it or not. ``combination`` is needed where several have such a choice, ``representation`` is the first by
    default. One of these may be different from the plan: ``dead`` names sensors of the choice that are dead, ``draw`` the
    number of a draw of ``[mounting_error]``, ``posture`` one of ``[postures]``, as in "standing/0".
    """

    _native: _perirobot.Study

    def why(
        self,
        poses: str,
        *,
        combination: str | None = None,
        representation: str | None = None,
        scene: str | None = None,
        snapshot: int = 0,
        repeat: int = 0,
        dead: Iterable[str] = (),
        draw: int | None = None,
        posture: str | None = None,
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
    ) -> Why:
        """Why voxels of the regions stay unknown to a choice of poses at one moment, and which object is to blame.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> why = study.why("camera:right-wall/8/1")
        >>> print(why)
        >>> why.to_pandas().groupby("reason").voxels_human.sum()

        :raises ValueError: for a name that is unknown, with those that are known.
        """
        choice = (poses, combination, representation, scene, index("snapshot", snapshot), index("repeat", repeat))
        return Why(*_perirobot.why(self._native, choice, _altered(dead, draw, posture), words(backend, adapter, threads)))

    def approach(
        self,
        poses: str,
        out: str | PathLike[str] | None = None,
        *,
        combination: str | None = None,
        representation: str | None = None,
        repeat: int = 0,
        dead: Iterable[str] = (),
        draw: int | None = None,
        posture: str | None = None,
        progress: bool = True,
    ) -> Approach:
        """How near the bodies of ``[approach]`` come to the robot unnoticed, in all scenes.

        >>> study = pr.Study.load("scenes/approach.toml")
        >>> near = study.approach("camera:wall/front")
        >>> near.to_pandas()[["body", "entry", "deepest_m"]]

        :param out: folder for the files that ``perirobot approach`` writes; a temporary one by default.
        :raises ValueError: if the study has no table ``approach``, or for a name that is unknown.
        """
        answer = Approach(None, out)
        choice = (poses, combination, representation, None, 0, index("repeat", repeat))
        with shown(progress) as bars:
            answer.text = _perirobot.approach(self._native, choice, _altered(dead, draw, posture), answer.folder, bars)
        return answer

    def export(
        self,
        poses: str,
        out: str | PathLike[str],
        *,
        combination: str | None = None,
        representation: str | None = None,
        scene: str | None = None,
        snapshot: int = 0,
        repeat: int = 0,
        dead: Iterable[str] = (),
        draw: int | None = None,
        posture: str | None = None,
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
    ) -> dict[str, str]:
        """Writes what a choice of poses sees at one moment for other programs: ``view.mcap`` for Foxglove and ROS 2, OctoMaps,
        point clouds, ``view.npz``, and the cell as glTF.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> study.export("camera:right-wall/8/1", "out/view")

        :param out: the folder, made if needed.
        :returns: the names of the files, and what they hold.
        :raises ValueError: for a name that is unknown, with those that are known.
        """
        choice = (poses, combination, representation, scene, index("snapshot", snapshot), index("repeat", repeat))
        altered, device = _altered(dead, draw, posture), words(backend, adapter, threads)
        return dict(_perirobot.export(self._native, choice, altered, os.fspath(out), device))

    def render(
        self,
        poses: str | None = None,
        *,
        combination: str | None = None,
        representation: str | None = None,
        scene: str | None = None,
        snapshot: int = 0,
        repeat: int = 0,
        dead: Iterable[str] = (),
        draw: int | None = None,
        posture: str | None = None,
        floor_plan: bool = False,
        eye: str | Sequence[float] = "iso",
        look_at: Sequence[float] | None = None,
        fov_deg: float = 45.0,
        size: tuple[int, int] = (960, 600),
        colour: Literal["label", "role", "height", "x"] | None = None,
        only_region: str | None = None,
        cut_above: float | None = None,
        open: float = 0.1,
        points: int = 3000,
        approach: bool = False,
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
    ) -> Picture:
        """Draws a scene, or what a choice of poses makes of it; notebooks show the picture.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> study.render("camera:right-wall/8/1").save("pose.png")
        >>> study.render("camera:right-wall/8/1", floor_plan=True).save("plan.svg")

        :param poses: nothing is cast without them.
        :param floor_plan: an SVG from above, instead of a PNG; what follows is for a PNG, but for ``approach``.
        :param eye: x, y, z in metres, or "iso", "top", "front", "back", "left", "right" or "bottom".
        :param look_at: the middle of the picture, x, y, z in metres; by default that of the cell.
        :param fov_deg: full horizontal angle of view.
        :param size: width and height in pixels.
        :param colour: by default "label" with poses, "role" without.
        :param only_region: draws only what is in this region.
        :param cut_above: draws nothing above this height in metres.
        :param open: leaves out walls up to this thick between the eye and the cell, metres.
        :param points: about how many returns of each sensor are drawn.
        :param approach: draws the ways on which bodies of ``[approach]`` come nearest unnoticed; needs poses.
        :raises ValueError: for an argument that is wrong.
        """
        if poses is None and (approach or dead or draw is not None or posture):
            raise ValueError("poses: name a choice of poses, which approach, dead, draw and posture are about")
        side, eye_m = (eye, None) if isinstance(eye, str) else ("iso", three("eye", eye))
        look_at_m = three("look_at", look_at)
        width, height = (index("size", side_px) for side_px in size)
        wish: dict[str, Any] = {"side": side, "eye_m": eye_m, "look_at_m": look_at_m, "fov_deg": float(fov_deg)}
        wish |= {"size": [width, height], "colour": colour, "only_region": only_region, "cut_above": cut_above}
        wish |= {"open": float(open), "points": index("points", points), "approach": approach, "floor_plan": floor_plan}
        moment = (scene, index("snapshot", snapshot), index("repeat", repeat))
        choice = (poses or "", combination, representation, *moment)
        device = words(backend, adapter, threads)
        picture = _perirobot.render(self._native, choice, _altered(dead, draw, posture), wish, device)
        return Picture(picture, "svg" if floor_plan else "png")

    def judge(
        self,
        sets: Best | Purchase | str,
        *,
        combination: str | None = None,
        representation: str | None = None,
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
    ) -> pandas.DataFrame:
        """Decides which sets meet the requirements of the study, also with sensors dead and mounts off where they ask for that.

        Does what ``perirobot judge`` does. Of sets that :meth:`choose` or :meth:`cheapest` found, it writes the same tables into
        their folder. Needs pandas.

        >>> study = pr.Study.load("scenes/judge.toml", voxel_size_m=0.2)
        >>> verdicts = study.judge("camera:right-wall/0/0;camera:right-wall/4/0")
        >>> verdicts[["requirement", "condition", "verdict"]]

        :param sets: the best or the cheapest sets, or the name of one choice of poses.
        :returns: a row for each set, requirement and condition, the columns of ``requirements.csv``; ``verdict`` is PASS or FAIL.
        :raises ValueError: if nothing is required, the study is not the one of the sets, or a name is unknown.
        """
        tables, device = needed("pandas", "tables"), words(backend, adapter, threads)
        with shown(progress) as bars, tempfile.TemporaryDirectory(prefix="perirobot-") as temporary:
            if isinstance(sets, str):
                folder = temporary
                choice = (sets, combination, representation, None, 0, 0)
                _perirobot.judge_choice(self._native, choice, folder, device, bars)
            else:
                folder = sets.folder
                _perirobot.judge(self._native, folder, device, bars)
            verdicts: pandas.DataFrame = tables.read_csv(os.path.join(folder, "requirements.csv"))
        return verdicts

    def report(
        self,
        out: str | PathLike[str],
        results: Best | Purchase | str | PathLike[str] | None = None,
        *,
        best: int | None = None,
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
        progress: bool = True,
    ) -> str:
        """Writes the page of ``perirobot report``: one HTML file that needs no network.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> study.report("report.html", best=1)

        :param out: the file.
        :param results: what :meth:`choose` or :meth:`cheapest` found, or the folder of a sweep of this study. By default the
            study is swept and judged for the page.
        :param best: how many of the best choices are shown voxel by voxel.
        :returns: the path of the file.
        :raises ValueError: if the results are not of this study.
        """
        path, device = os.fspath(out), words(backend, adapter, threads)
        asked = (path, None if best is None else index("best", best))
        with shown(progress) as bars, tempfile.TemporaryDirectory(prefix="perirobot-") as temporary:
            if results is None:
                folder = temporary
                self._native.sweep_into(folder, device, bars)
                if self._native.has_requirements:
                    _perirobot.judge(self._native, folder, device, bars)
            else:
                folder = results.folder if isinstance(results, Answer) else os.fspath(results)
            _perirobot.report(self._native, folder, asked, device, bars)
        return path


def _altered(dead: Iterable[str], draw: int | None, posture: str | None) -> tuple[list[str], int | None, str | None]:
    """What is not as planned, as the compiled half takes it."""
    without = texts("dead", dead)
    if bool(without) + (draw is not None) + (posture is not None) > 1:
        raise ValueError("dead, draw, posture: say one of them")
    return without, None if draw is None else index("draw", draw), posture
