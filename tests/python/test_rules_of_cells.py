"""Rules of cells as they are, counted by numpy: radar, objects on links, safety planes, floors at several heights."""

import math
import unittest
import warnings

import numpy as np

import perirobot as pr
from shared import ROOT
from shared_rules import VOXEL_M, path, quantised

ALL = {"name": "all", "box": {"min_m": [-9, -9, -9], "max_m": [9, 9, 9]}}


def study_of(objects: list[dict[str, object]], bounds: list[list[float]], **keys: object) -> pr.Study:
    """A study of one scene in a grid; its region is all of it unless another is given."""
    grid = {"voxel_size_m": VOXEL_M, "bounds_m": {"min": bounds[0], "max": bounds[1]}}
    return pr.Study({"grid": grid, "region": [ALL], **keys}, scenes={"cell": {"object": objects}}, folder=ROOT)


def middles(truth: pr.Truth) -> list[np.ndarray]:
    """The coordinates of the middles of a grid's voxels, in metres."""
    sides = [low + VOXEL_M * (np.arange(n) + 0.5) for low, n in zip(truth.origin_m, truth.occupied.shape)]
    return list(np.meshgrid(*sides, indexing="ij"))


class Quiet(unittest.TestCase):
    def setUp(self) -> None:
        context = warnings.catch_warnings()
        context.__enter__()
        self.addCleanup(context.__exit__, None, None, None)
        # Of small cells: regions larger than their grid, sensors in the air.
        warnings.simplefilter("ignore", pr.InputWarning)


class Radar(Quiet):
    POSITION_M = (0.52, 0.13, 1.04)
    FOV_DEG = (70, 30)
    RANGE_M = (0.4, 4.0)

    def compare(self, screen: str, speed_m_s: float, slowest_m_s: float) -> bool:
        """Compares a radar's labels with a plain march, and gives whether it is on."""
        objects = [
            {"name": "screen", "box": {"size_m": [0.1, 2.6, 1.6]}, "position_m": [1.75, 0.03, 0.93], "radar": screen},
            {"name": "post", "box": {"size_m": [0.2, 0.2, 1.7]}, "position_m": [2.3, -0.6, 0.9]},
            {
                "name": "person",
                "role": "human",
                "cylinder": {"radius_m": 0.25, "height_m": 1.7},
                "position_m": [2.81, 0.32, 0.9],
                "speed_m_s": speed_m_s,
            },
        ]
        place = {"position_m": list(self.POSITION_M), "facing": [1, 0, 0]}
        radar = {
            "name": "radar",
            "kind": "radar",
            "fov_deg": list(self.FOV_DEG),
            "range_m": list(self.RANGE_M),
            "min_speed_m_s": slowest_m_s,
            "poses": [{"name": "post", "list": [place]}],
        }
        study = study_of(objects, [[0, -2, 0], [5, 2, 2]], sensor=[radar])
        truth = study.truth()
        x, y, _ = middles(truth)
        is_screen = truth.occupied & ~truth.human & (x < 2.0)
        stops = truth.occupied & ~is_screen if screen == "passes" else truth.occupied
        low = [round(edge / VOXEL_M) for edge in truth.origin_m]
        origin = [
            quantised(at / VOXEL_M * 65536) - (corner << 16) for at, corner in zip(self.POSITION_M, low)
        ]
        nearest, farthest = (quantised(metres / VOXEL_M * 65536) for metres in self.RANGE_M)
        spans = [math.radians(angle) for angle in self.FOV_DEG]
        counts = [math.ceil(span * (farthest / 65536) * 1.5) + 1 for span in spans]
        angles = [
            [span * (number / (count - 1) - 0.5) for number in range(count)] for span, count in zip(spans, counts)
        ]
        sensed = np.zeros(truth.occupied.shape, bool)
        for azimuth in angles[0]:
            for elevation in angles[1]:
                across = math.cos(elevation)
                unit = [across * math.cos(azimuth), across * math.sin(azimuth), math.sin(elevation)]
                direction = [2 * quantised(part * 32768) for part in unit]
                for distance, voxel in path(origin, direction, truth.occupied.shape):
                    if distance > farthest:
                        break
                    if distance >= nearest:
                        sensed[voxel] = True
                    if stops[voxel]:
                        break
        people = truth.human & truth.occupied
        moving = people & (round(speed_m_s * 1000) >= round(slowest_m_s * 1000))
        felt = sensed & moving
        field = sensed & (~stops | people)
        expected = np.where(field, pr.OCCUPIED if felt.any() else pr.FREE, pr.UNKNOWN)
        self.assertTrue(pr.UNKNOWN in expected and field.sum() > 500, "a field of some size")
        for backend in ("cpu", "oracle"):
            found = study.labels("post/0", backend=backend)
            np.testing.assert_array_equal(found.labels, expected, backend)
            np.testing.assert_array_equal(found.hits, felt, backend)
        return bool(felt.any())

    def test_who_walks_behind_plastic_is_detected(self) -> None:
        self.assertTrue(self.compare("passes", 1.2, 0.1))

    def test_who_stands_still_is_not(self) -> None:
        self.assertFalse(self.compare("passes", 0.0, 0.1))
        self.assertFalse(self.compare("passes", 0.2994, 0.3))
        self.assertTrue(self.compare("passes", 0.2995, 0.3))
        self.assertTrue(self.compare("passes", 0.0, 0.0))

    def test_a_wall_hides_who_walks(self) -> None:
        self.assertFalse(self.compare("stops", 1.2, 0.1))


class Robots(Quiet):
    BASE_M = np.array([0.3, -0.2, 0.0])
    BOUNDS = ((-2, -2, 0), (2, 2, 2.5))
    PAD = {"name": "pad", "kind": "pad", "size_m": [0.4, 0.4], "height_m": 1.0}

    def study(self, objects: list[dict[str, object]], *regions: dict[str, object]) -> pr.Study:
        place = {"position_m": [1.5, 1.5, 0.05], "facing": [1, 0, 0]}
        pad = {**self.PAD, "poses": [{"name": "floor", "list": [place]}]}
        return study_of(objects, [list(corner) for corner in self.BOUNDS], sensor=[pad], region=[ALL, *regions])

    def robot(self, angles_deg: list[list[float]]) -> dict[str, object]:
        joints = [{"shoulder": shoulder, "elbow": elbow} for shoulder, elbow in angles_deg]
        place = {"position_m": list(self.BASE_M), "snapshots": {"joints_deg": joints}}
        return {"name": "robot", "urdf": "scenes/tutorial/robot.urdf", **place}

    def test_a_gripper_is_where_its_link_is(self) -> None:
        angles_deg = [[0.0, 0.0], [35.0, 20.0], [-80.0, 47.0], [110.0, -130.0]]
        offset, box = np.array([0.01, 0.05, 0.25]), {"size_m": [0.5, 0.3, 0.2]}
        on = {"object": "robot", "link": "tool0"}
        robot = self.robot(angles_deg)
        carried = self.study([robot, {"name": "gripper", "box": box, "on": on, "position_m": list(offset)}])
        for snapshot, (shoulder, elbow) in enumerate(angles_deg):
            place, heading = self.BASE_M + np.array([0.0, 0.0, 0.7]), 0.0
            for turn in (shoulder, elbow):
                heading += turn
                ahead = np.array([math.cos(math.radians(heading)), math.sin(math.radians(heading)), 0.0])
                place = place + 0.45 * ahead
            left = np.array([-ahead[1], ahead[0], 0.0])
            middle = place + offset[0] * ahead + offset[1] * left + np.array([0.0, 0.0, offset[2]])
            beside = {"name": "gripper", "box": box, "role": "robot", "position_m": list(middle)}
            free = self.study([self.robot([[shoulder, elbow]]), {**beside, "rpy_deg": [0, 0, heading]}])
            truth, expected = carried.truth(snapshot=snapshot), free.truth()
            self.assertGreater(int(expected.robot.sum()), 150)
            np.testing.assert_array_equal(truth.occupied, expected.occupied, f"snapshot {snapshot}")
            np.testing.assert_array_equal(truth.robot, expected.robot, f"snapshot {snapshot}")

    def test_safety_planes_cut_the_reach(self) -> None:
        planes = [([0.8, 0.0, 0.0], [-1, 0, 0]), ([0.0, -0.53, 0.4], [0.3, 1.0, 0.2])]
        cut = [{"point_m": point, "normal": normal} for point, normal in planes]
        study = self.study(
            [self.robot([[0.0, 0.0]])],
            {"name": "reach", "robot_reach": {"tool_m": 0.1}},
            {"name": "cut", "robot_reach": {"tool_m": 0.1, "planes": cut}},
        )
        truth = study.truth()
        stays = np.ones(truth.occupied.shape, bool)
        for point, normal in planes:
            stays &= sum(n * (side - p) for n, side, p in zip(normal, middles(truth), point)) >= 0
        whole, rest = truth.regions["reach"], truth.regions["cut"]
        np.testing.assert_array_equal(rest, whole & stays)
        self.assertTrue(0.2 < rest.sum() / whole.sum() < 0.8)


class Floors(Quiet):
    """A low platform, steps to a gallery, and a conveyor that only long legs climb."""

    SIZE = (30, 24, 26)
    BODY = (3, 3, 10)

    def objects(self) -> list[dict[str, object]]:
        def box(name: str, low: list[float], high: list[float]) -> dict[str, object]:
            # A hair inside the voxels from low to high, of which the higher is the first that does not belong to it.
            size = [0.1 * (b - a) - 0.02 for a, b in zip(low, high)]
            return {"name": name, "box": {"size_m": size}, "position_m": [0.05 * (a + b) for a, b in zip(low, high)]}

        return [
            box("floor", [0, 0, 0], [30, 24, 1]),
            box("platform", [3, 3, 1], [10, 9, 3]),
            box("step one", [12, 16, 1], [16, 22, 3]),
            box("step two", [16, 16, 1], [20, 22, 5]),
            box("gallery", [20, 12, 6], [29, 22, 7]),
            box("conveyor", [12, 2, 1], [22, 6, 8]),
            {**box("robot", [26, 2, 1], [28, 4, 9]), "role": "robot"},
        ]

    def places(self, solid: np.ndarray, carriers: np.ndarray, step: int) -> np.ndarray:
        """Lowest corners of the body where it stands, joined by steps to the west of the room."""
        above = np.zeros_like(solid)
        above[:, :, :-1] = solid[:, :, 1:]
        surfaces = carriers & ~above
        room = np.zeros(solid.shape, bool)
        n, m, h = self.BODY
        for x in range(solid.shape[0] - n + 1):
            for y in range(solid.shape[1] - m + 1):
                for z in range(1, solid.shape[2] - h + 1):
                    body = solid[x : x + n, y : y + m, z : z + h]
                    room[x, y, z] = not body.any() and surfaces[x : x + n, y : y + m, z - 1].any()
        found = np.zeros_like(room)
        waiting = [(2, 16, 1)]
        while waiting:
            x, y, z = waiting.pop()
            if not (0 <= x < room.shape[0] and 0 <= y < room.shape[1] and room[x, y, z]) or found[x, y, z]:
                continue
            found[x, y, z] = True
            for i in (-1, 0, 1):
                for j in (-1, 0, 1):
                    waiting += [(x + i, y + j, z + k) for k in range(-step, step + 1) if 0 <= z + k < room.shape[2]]
        return found

    def test_bodies_walk_where_steps_lead(self) -> None:
        walked = []
        for step in (1, 2, 7):
            body = {"name": "person", "box": {"size_m": [VOXEL_M * side for side in self.BODY]}, "on_floor": True}
            entry = {"name": "west", "box": {"min_m": [0.0, 1.4, 0.0], "max_m": [0.8, 2.2, 2.0]}}
            approach = {"floor": "auto", "step_m": 0.1 * step, "min_voxels": 1, "body": [body], "entry": [entry]}
            # It watches nothing that a body fills.
            curtain = {
                "name": "curtain",
                "kind": "gate",
                "box": {"min_m": [0, 0, 2.5], "max_m": [0.1, 0.1, 2.6]},
                "zone": {"min_m": [0, 0, 2.5], "max_m": [0.1, 0.1, 2.6]},
            }
            study = study_of(
                self.objects(), [[0, 0, 0], [0.1 * n for n in self.SIZE]], sensor=[curtain], approach=approach
            )
            truth = study.truth()
            rows = study.approach("here", progress=False).to_pandas()
            places = self.places(truth.occupied, truth.occupied & ~truth.robot, step)
            walked.append(int(places.sum()))
            self.assertAlmostEqual(float(rows.joined_m2.iloc[0]), 0.01 * walked[-1], 5, f"step {step}")
        self.assertEqual(walked, sorted(set(walked)), "longer legs get farther")


if __name__ == "__main__":
    unittest.main()
