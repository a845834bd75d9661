"""Environments of gymnasium: their rules, and that their rewards are the scores of the sweep."""

import subprocess
import sys
import unittest
import warnings

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env

import perirobot as pr
from shared import ROOT


def study() -> pr.Study:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        study = pr.Study.load(ROOT / "scenes/sensors.toml")
        study.truth()
    return study


class Environments(unittest.TestCase):
    def test_the_checker_of_gymnasium_is_content(self):
        for reward in ("f1", "unknown"):
            env = pr.gym.PlaceSensors(study(), sensors=["camera"], reward=reward, margin_m=0.2, backend="cpu")
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.filterwarnings("ignore", message=".*different to the unwrapped version.*")
                warnings.filterwarnings("ignore", message=".*not having a.*spec.*|.*env.spec.*")
                check_env(env, skip_render_check=True)

    def test_rewards_are_pooled_scores_at_the_poses(self):
        whole = study()
        for reward, sign in (("f1", 1), ("false_alarm", -1), ("parts_detected", 1)):
            region = whole.regions[-1]
            env = pr.gym.PlaceSensors(
                whole, sensors=["camera", "camera"], reward=reward, region=region, margin_m=0.2, backend="cpu"
            )
            env.reset(seed=3)
            env.action_space.seed(3)
            for _ in range(3):
                action = env.action_space.sample()
                observation, got, terminated, truncated, info = env.step(action)
                self.assertFalse(terminated or truncated)
                poses = info["poses"]["camera"]
                self.assertEqual(poses.shape, (2, 7))
                low, high = env._placing.low_m, env._placing.high_m
                np.testing.assert_allclose(poses[1, :3], low + (action[5:8] + 1.0) / 2 * (high - low), atol=1e-6)
                yaw, down = float(action[8]) * np.pi, float(action[9]) * np.pi / 2
                ahead = [np.cos(yaw) * np.cos(down), np.sin(yaw) * np.cos(down), -np.sin(down)]
                w, x, y, z = poses[1, 3:]
                turned = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
                np.testing.assert_allclose(turned, ahead, atol=1e-6)
                counts = whole.evaluate(poses[None], "camera", backend="cpu")[0, :, :, 0].sum(axis=(0, 1))
                value = float(pr.score(counts[whole.regions.index(region)], reward))
                self.assertEqual(got, 0.0 if np.isnan(value) else sign * value)
                shares = observation[: 6 * len(whole.regions)].reshape(-1, 6)
                np.testing.assert_allclose(shares, counts[:, :6] / counts[:, :6].sum(axis=1, keepdims=True), atol=1e-6)
                np.testing.assert_array_equal(observation[-10:], action)

    def test_episodes_are_those_of_the_seed_and_end(self):
        whole = study()

        def episode(seed: int) -> list[np.ndarray]:
            env = pr.gym.PlaceSensors(whole, sensors=["camera"], margin_m=0.2, steps=3, backend="cpu")
            env.action_space.seed(seed)
            seen = [env.reset(seed=seed)[0]]
            truncated = False
            while not truncated:
                observation, reward, _, truncated, _ = env.step(env.action_space.sample())
                seen += [observation, np.array(reward)]
            return seen

        first, again, other = episode(1), episode(1), episode(2)
        self.assertEqual(len(first), 7)
        for one, same in zip(first, again):
            np.testing.assert_array_equal(one, same)
        self.assertFalse(np.array_equal(first[0], other[0]))

    def test_batches_are_single_steps(self):
        whole = study()
        keys = {"sensors": ["camera"], "reward": "human_seen", "margin_m": 0.2, "steps": 2, "backend": "cpu"}
        envs = pr.gym.PlaceSensorsVector(whole, 3, **keys)
        singles = [pr.gym.PlaceSensors(whole, **keys) for _ in range(3)]
        together, _ = envs.reset(seed=7)
        apart = np.stack([env.reset(seed=7 + n)[0] for n, env in enumerate(singles)])
        np.testing.assert_array_equal(together, apart)
        self.assertTrue(envs.observation_space.contains(together))
        envs.action_space.seed(0)
        for number in range(6):
            actions = envs.action_space.sample()
            observations, rewards, terminated, truncated, _ = envs.step(actions)
            ends = number % 3 == 1
            self.assertEqual((terminated.any(), truncated.all(), truncated.any()), (False, ends, ends))
            if number % 3 == 2:
                expected = [(env.reset()[0], 0.0) for env in singles]
            else:
                expected = [env.step(action)[:2] for env, action in zip(singles, actions)]
            np.testing.assert_array_equal(observations, np.stack([one for one, _ in expected]))
            np.testing.assert_array_equal(rewards, [value for _, value in expected])
            if number % 3 != 2:
                looked = singles[0].look(actions)
                np.testing.assert_array_equal(looked[0], observations)
                np.testing.assert_array_equal(looked[1], rewards)

    def test_what_is_wrong_is_refused(self):
        whole = study()
        for keys, message in [
            ({"sensors": ["camra"]}, "sensors: 'camra' must be one of"),
            ({"sensors": []}, "sensors: name one that takes poses"),
            ({"region": "nowhere"}, "region = 'nowhere': must be one of"),
            ({"reward": "f2"}, "score f2"),
            ({"margin_m": 5}, "bounds_m, margin_m: leave no room"),
            ({"bounds_m": ([0, 0], [1, 1])}, "bounds_m = .*must be x, y, z"),
            ({"steps": -1}, "steps = -1: must be a whole number"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                pr.gym.PlaceSensors(whole, **keys)
        env = pr.gym.PlaceSensors(whole, sensors=["camera"], margin_m=0.2, backend="cpu")
        with self.assertRaisesRegex(ValueError, r"options\['action'\]: has shape \(3,\)"):
            env.reset(options={"action": [0, 0, 0]})
        with self.assertRaisesRegex(ValueError, r"actions: has shape \(5,\), must be \(n, 5\)"):
            env.look(np.zeros(5))
        self.assertIsInstance(env, gymnasium.Env)

    def test_without_gymnasium_the_extra_is_named(self):
        code = (
            "import sys; sys.modules['gymnasium'] = None\n"
            "import perirobot as pr\n"
            "try: pr.gym\nexcept ModuleNotFoundError as error: print(error)"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        self.assertIn("this needs gymnasium, which is not installed: pip install 'perirobot[gym]'", done.stdout, done.stderr)
        done = subprocess.run([sys.executable, "-c", "import perirobot, sys; print('gymnasium' in sys.modules)"], capture_output=True, text=True)
        self.assertEqual(done.stdout.strip(), "False", done.stderr)


class Helpers(unittest.TestCase):
    def test_scores_of_counts_are_those_of_the_table(self):
        whole = pr.Study.load(ROOT / "scenes/quick.toml", voxel_size_m=0.2)
        names, poses = whole.poses("camera")
        rows = whole.sweep("cpu", progress=False).to_pandas().query("combination == 'camera'")
        rows = rows[rows.representation == rows.representation.iloc[0]].set_index(["poses", "region"]).sort_index()
        counts = whole.evaluate(poses, "camera", backend="cpu")[:, 0, 0, 0]
        for score in ("f1", "kappa", "human_seen", "human_claimed", "people_detected", "unknown", "false_alarm", "seen_twice"):
            expected = [[rows.loc[(f"camera:{name}", region), score] for region in whole.regions] for name in names]
            np.testing.assert_array_equal(pr.score(counts, score), np.array(expected, float))
        for wrong, message in [(np.zeros(6, int), r"counts: has shape \(6,\)"), ("x", "counts: must be an array")]:
            with self.assertRaisesRegex(ValueError, message):
                pr.score(wrong, "f1")
        with self.assertRaisesRegex(ValueError, "score f2"):
            pr.score(counts, "f2")

    def test_sensors_look_at_points(self):
        random = np.random.default_rng(5)
        at, to = random.uniform(-2, 2, (2, 50, 3))
        rows = pr.look_at(at, to)
        np.testing.assert_array_equal(rows[:, :3], at)
        w, x, y, z = rows[:, 3:].T
        np.testing.assert_allclose(w**2 + x**2 + y**2 + z**2, 1)
        ahead = np.stack([1 - 2 * (y**2 + z**2), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=1)
        way = to - at
        np.testing.assert_allclose(ahead, way / np.linalg.norm(way, axis=1, keepdims=True), atol=1e-12)
        np.testing.assert_allclose(2 * (y * z + w * x), 0, atol=1e-12, err_msg="the left is level")
        self.assertTrue((1 - 2 * (x**2 + y**2) >= -1e-12).all(), "and the sensor upright")
        np.testing.assert_allclose(pr.look_at([0, 0, 2], [0, 0, 0]), [0, 0, 2, np.sqrt(0.5), 0, np.sqrt(0.5), 0])
        self.assertEqual(pr.look_at(np.zeros((2, 3, 3)), [1, 0, 0]).shape, (2, 3, 7))
        for wrong, message in [
            (([0, 0], [0, 0, 0]), r"position_m: has shape \(2,\)"),
            (([0, 0, 0], [0, 0, np.nan]), "target_m: .*finite"),
            (([0, 0, 0], [0, 0, 0]), "target_m: is where the sensor is"),
            ((np.zeros((2, 3)), np.ones((3, 3))), r"target_m: has shape \(3, 3\)"),
        ]:
            with self.assertRaisesRegex(ValueError, message):
                pr.look_at(*wrong)

    def test_listed_poses_that_face_a_point_count_the_same(self):
        keys = {"name": "camera", "kind": "rgbd", "fov_deg": [87, 58], "resolution_px": [64, 48], "range_m": [0.1, 8]}
        keys["poses"] = [{"name": "one", "list": [{"position_m": [0.2, 0.3, 2.1], "facing": [1, 0.5, -0.7]}]}]
        occupied = np.zeros((40, 30, 25), bool)
        occupied[:, :, 0] = occupied[20:24, 10:14, :12] = True
        region = {"name": "all", "box": {"min_m": [0, 0, 0], "max_m": [4, 3, 2.5]}}
        whole = pr.Study({"region": [region], "sensor": [keys]}, scenes={"cell": pr.Cell(occupied, 0.1)})
        listed = whole.evaluate(whole.poses()[1], backend="cpu")
        looking = whole.evaluate(pr.look_at([0.2, 0.3, 2.1], [1.2, 0.8, 1.4]), backend="cpu")
        np.testing.assert_array_equal(looking, listed)


if __name__ == "__main__":
    unittest.main()
