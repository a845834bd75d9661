"""Environments of gymnasium, in which an agent places the sensors of a study; ``pip install 'perirobot[gym]'``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _perirobot
from .checks import array, index, needed, three
from .counts import COUNTERS, score
from .device import Backend
from .poses import facing
from .study import Study

needed("gymnasium", "gym")
import gymnasium  # noqa: E402

_Array = NDArray[Any]
_Info = dict[str, Any]

#: The numbers of an action for each sensor: x, y, z, yaw, and how far it looks down.
_NUMBERS = 5

#: The counters of labels, which are observed as shares of a region.
_OBSERVED = 6


class _Placing:
    """What both environments share: the poses of actions, and what they score."""

    def __init__(
        self,
        study: Study,
        sensors: Sequence[str] | None,
        reward: str,
        region: str | None,
        bounds_m: tuple[ArrayLike, ArrayLike] | None,
        margin_m: float,
        device: dict[str, Any],
    ) -> None:
        self.study, self.reward, self.device = study, reward, device
        self.sensors = list(study.sensors if sensors is None else sensors)
        if not self.sensors:
            raise ValueError("sensors: name one that takes poses")
        unknown = [name for name in self.sensors if name not in study.sensors]
        if unknown:
            raise ValueError(f"sensors: {unknown[0]!r} must be one of {study.sensors}")
        region = study.regions[0] if region is None else region
        if region not in study.regions:
            raise ValueError(f"region = {region!r}: must be one of {study.regions}")
        self.region = study.regions.index(region)
        # Fails at once for an unknown score.
        score(np.zeros(len(COUNTERS), np.int64), reward)
        self.low_m, self.high_m = self._bounds(bounds_m, float(margin_m))
        self.size = len(self.sensors) * _NUMBERS
        self.observed = len(study.regions) * _OBSERVED + self.size

    def _bounds(self, bounds_m: tuple[ArrayLike, ArrayLike] | None, margin_m: float) -> tuple[_Array, _Array]:
        """Where sensors may be."""
        if bounds_m is not None:
            low, high = (np.array(three("bounds_m", corner)) for corner in bounds_m)
        else:
            grids = _perirobot.grids(self.study._native)
            corners = np.array([corner for *_, corner, _ in grids])
            sizes = np.array([size for *_, size in grids])
            low, high = corners.max(axis=0), (corners + sizes * self.study.voxel_size_m).min(axis=0)
            # The upper sides are in no voxel.
            low, high = low + margin_m, high - max(margin_m, self.study.voxel_size_m / 2)
        if not (low < high).all():
            raise ValueError(f"bounds_m, margin_m: leave no room from {low.tolist()} to {high.tolist()}")
        return low, high

    def poses(self, actions: _Array) -> dict[str, _Array]:
        """The poses of n actions as :meth:`perirobot.Study.evaluate` takes them: of each sensor shape (n, k, 7)."""
        parts = np.clip(actions.reshape(len(actions), -1, _NUMBERS).astype(np.float64), -1, 1)
        at = self.low_m + (parts[..., :3] + 1) / 2 * (self.high_m - self.low_m)
        rows = facing(at, parts[..., 3] * np.pi, parts[..., 4] * (np.pi / 2))
        names = np.array(self.sensors)
        return {name: rows[:, names == name] for name in dict.fromkeys(self.sensors)}

    def look(self, actions: _Array) -> tuple[_Array, _Array]:
        """Observations and rewards of n actions, counted together."""
        counts = self.study.evaluate(self.poses(actions), **self.device)[:, :, :, 0].sum(axis=(1, 2))
        labels = counts[:, :, :_OBSERVED]
        shares = labels / np.maximum(labels.sum(axis=-1, keepdims=True), 1)
        observations = np.concatenate([shares.reshape(len(actions), -1), np.clip(actions, -1, 1)], axis=1)
        values = score(counts[:, self.region], self.reward)
        is_worse = self.reward in ("unknown", "false_alarm")
        # A score without a value is never the best.
        worst = -1.0 if is_worse else 0.0
        return observations.astype(np.float32), np.nan_to_num(-values if is_worse else values, nan=worst)

    def action_space(self) -> gymnasium.spaces.Box:
        return gymnasium.spaces.Box(-1, 1, (self.size,), np.float32)

    def observation_space(self) -> gymnasium.spaces.Box:
        low = np.concatenate([np.zeros(self.observed - self.size), -np.ones(self.size)]).astype(np.float32)
        return gymnasium.spaces.Box(low, np.ones(self.observed, np.float32), dtype=np.float32)

    def start(self, random: np.random.Generator, options: Optional[dict[str, Any]]) -> _Array:
        """The action with which an episode begins: that of the options, else one at random."""
        if not options or "action" not in options:
            return random.uniform(-1, 1, self.size).astype(np.float32)
        action = array("options['action']", options["action"], np.float32)
        if action.shape != (self.size,):
            raise ValueError(f"options['action']: has shape {action.shape}, must be ({self.size},)")
        return action


class PlaceSensors(gymnasium.Env[_Array, _Array]):
    """Each step places all sensors; the reward is a score of what they see together.

    >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
    >>> env = pr.gym.PlaceSensors(study, sensors=["camera"], reward="human_seen", region="robot")
    >>> observation, info = env.reset(seed=1)
    >>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

    An action has five numbers from -1 to 1 for each sensor: x, y and z from the lower to the upper bound, the yaw from -180° to
    180° (0 looks along x, 90° along y), and how far it looks down, from -90° (up) to 90°. An observation has for each region the
    shares of its voxels that are tp, fp, fn, tn, uo and uf over all moments and repeats, and then the action. The reward is the
    pooled score in a region; the negative of ``unknown`` and ``false_alarm``, of which less is better; 0 if it has no value.

    :param study: its scenes, regions and sensors, the first representation of each; its listed poses do not matter.
    :param sensors: the names of those that are placed, all by default; a name twice is two equal sensors.
    :param reward: the score, as in the columns of the results.
    :param region: where it is rewarded; the first region by default.
    :param bounds_m: lowest and highest x, y, z of sensors; by default the voxels that all scenes have. For sensors on the link of
        a robot, in its frame.
    :param margin_m: how far sensors stay from the sides of the voxels, for mounts that are off.
    :param steps: placements until an episode is truncated.
    :param backend: as in :meth:`perirobot.Study.evaluate`, with ``adapter`` and ``threads``.
    :raises ValueError: for an argument that is wrong.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        study: Study,
        *,
        sensors: Sequence[str] | None = None,
        reward: str = "f1",
        region: str | None = None,
        bounds_m: tuple[ArrayLike, ArrayLike] | None = None,
        margin_m: float = 0.0,
        steps: int = 50,
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
    ) -> None:
        device = {"backend": backend, "adapter": adapter, "threads": threads}
        self._placing = _Placing(study, sensors, reward, region, bounds_m, margin_m, device)
        self.action_space = self._placing.action_space()
        self.observation_space = self._placing.observation_space()
        self._steps, self._done = index("steps", steps), 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[_Array, _Info]:
        """Begins an episode with sensors at random, or at ``options["action"]``.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> env = pr.gym.PlaceSensors(study, sensors=["camera"])
        >>> observation, info = env.reset(seed=1, options={"action": np.zeros(5)})
        """
        super().reset(seed=seed)
        self._done = 0
        observation, _, info = self._place(self._placing.start(self.np_random, options))
        return observation, info

    def step(self, action: _Array) -> tuple[_Array, float, bool, bool, _Info]:
        """Places the sensors. ``info["poses"]`` has the poses as :meth:`perirobot.Study.evaluate` takes them.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> env = pr.gym.PlaceSensors(study, sensors=["camera"])
        >>> observation, info = env.reset(seed=1)
        >>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
        """
        self._done += 1
        observation, reward, info = self._place(np.asarray(action, np.float32))
        return observation, reward, False, self._done >= self._steps, info

    def look(self, actions: ArrayLike) -> tuple[_Array, _Array]:
        """Observations and rewards of n actions, shape (n, numbers), counted together; the episode stays as it is.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> env = pr.gym.PlaceSensors(study, sensors=["camera"])
        >>> observations, rewards = env.look(np.zeros((8, 5)))
        """
        given = array("actions", actions, np.float32)
        if given.ndim != 2 or given.shape[1] != self._placing.size:
            raise ValueError(f"actions: has shape {given.shape}, must be (n, {self._placing.size})")
        return self._placing.look(given)

    def _place(self, action: _Array) -> tuple[_Array, float, _Info]:
        observations, rewards = self.look(action[None])
        poses = {name: rows[0] for name, rows in self._placing.poses(action[None]).items()}
        return observations[0], float(rewards[0]), {"poses": poses}


class PlaceSensorsVector(gymnasium.vector.VectorEnv[_Array, _Array, _Array]):
    """Several :class:`PlaceSensors`; the placements of a step are counted in one call.

    >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
    >>> envs = pr.gym.PlaceSensorsVector(study, 16, sensors=["camera"], reward="kappa")
    >>> observations, infos = envs.reset(seed=1)
    >>> observations, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())

    The arguments are those of :class:`PlaceSensors`. After the end of an episode, the next step begins a new one.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        study: Study,
        num_envs: int,
        *,
        sensors: Sequence[str] | None = None,
        reward: str = "f1",
        region: str | None = None,
        bounds_m: tuple[ArrayLike, ArrayLike] | None = None,
        margin_m: float = 0.0,
        steps: int = 50,
        backend: Backend = "auto",
        adapter: str | None = None,
        threads: int | None = None,
    ) -> None:
        device = {"backend": backend, "adapter": adapter, "threads": threads}
        self._placing = _Placing(study, sensors, reward, region, bounds_m, margin_m, device)
        self.num_envs = index("num_envs", num_envs)
        self.single_action_space = self._placing.action_space()
        self.single_observation_space = self._placing.observation_space()
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, num_envs)
        self._steps, self._done = index("steps", steps), np.zeros(num_envs, np.int64)
        self._ended = np.zeros(num_envs, np.bool_)
        self._randoms = [np.random.default_rng() for _ in range(num_envs)]

    def reset(
        self, *, seed: Union[int, Sequence[int | None], None] = None, options: dict[str, Any] | None = None
    ) -> tuple[_Array, _Info]:
        """Begins all episodes; of one seed, environment n has seed + n.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> envs = pr.gym.PlaceSensorsVector(study, 4, sensors=["camera"])
        >>> observations, infos = envs.reset(seed=1)
        """
        seeds = [seed + n for n in range(self.num_envs)] if isinstance(seed, int) else seed or []
        for n, own in enumerate(seeds):
            if own is not None:
                self._randoms[n] = gymnasium.utils.seeding.np_random(own)[0]
        self._done[:], self._ended[:] = 0, False
        actions = np.stack([self._placing.start(random, options) for random in self._randoms])
        return self._placing.look(actions)[0], {}

    def step(self, actions: _Array) -> tuple[_Array, _Array, _Array, _Array, _Info]:
        """Places the sensors of all environments.

        >>> study = pr.Study.load("scenes/quick.toml", voxel_size_m=0.2)
        >>> envs = pr.gym.PlaceSensorsVector(study, 4, sensors=["camera"])
        >>> observations, infos = envs.reset(seed=1)
        >>> observations, rewards, *_ = envs.step(envs.action_space.sample())
        """
        begins = self._ended
        placed = np.array(actions, np.float32).reshape(self.num_envs, self._placing.size)
        for n in np.flatnonzero(begins):
            placed[n] = self._placing.start(self._randoms[n], None)
        observations, rewards = self._placing.look(placed)
        self._done = np.where(begins, 0, self._done + 1)
        self._ended = self._done >= self._steps
        return observations, np.where(begins, 0.0, rewards), np.zeros(self.num_envs, np.bool_), self._ended, {}
