"""Asks again, by plain numpy and scipy, what `perirobot approach` answered: from the arrays of `perirobot export` it takes what is
watched by rays and what is solid, adds where switches feel, floods by Dijkstra's algorithm, and compares every row of approach.csv.
With floor = "auto" it finds surfaces, and the places to which bodies walk from entries, column by column.

The folder is named on the command line; tests/judge/approach.rs writes it: for each case case.json (the question), approach.csv, and
for people as cover and without them the view.npz of each snapshot.
"""

import heapq
import itertools
import json
import math
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.ndimage import distance_transform_edt



def steps(case, body):
    """How a body moves in a step, and how long the step is: to a neighbour, or walking to a column beside its own."""
    length = lambda d: math.isqrt(1_000_000 * sum(n * n for n in d))
    if not walks(case, body):
        return [(d, length(d)) for d in itertools.product([-1, 0, 1], repeat=3) if any(d)]
    most = math.ceil(case["step_m"] / case["voxel_m"] - 1e-9)
    columns = [d for d in itertools.product([-1, 0, 1], repeat=2) if any(d)]
    return [((x, y, z), length((x, y, z))) for x, y in columns for z in range(-most, most + 1)]


def walks(case, body):
    return case["step_m"] is not None and body["on_floor"]


def body_voxels(body, voxel_m, layers):
    """Offsets of a body's voxels from its lowest corner, and its size; on the floor it has only so many layers."""
    whole = lambda metres: max(1, int(np.floor(metres / voxel_m + 0.5)))
    if "box" in body:
        size = [whole(metres) for metres in body["box"]]
        round_axes = 0
    elif "cylinder" in body:
        diameter, height = body["cylinder"]
        size = [whole(diameter), whole(diameter), whole(height)]
        round_axes = 2
    else:
        size = [whole(body["ball"])] * 3
        round_axes = 3
    voxels = np.array(list(np.ndindex(*size)))
    if round_axes:
        n = size[0]
        off = voxels[:, :round_axes] + 0.5 - n / 2
        voxels = voxels[(off**2).sum(axis=1) < n * n / 4]
    if layers is not None:
        voxels, size[2] = voxels[voxels[:, 2] < layers], min(size[2], layers)
    return voxels, np.array(size)


def dijkstra(begin, open_, neighbours):
    lengths = np.full(open_.shape, -1, dtype=np.int64)
    heap = [(0, tuple(place)) for place in np.argwhere(begin & open_)]
    best = {place: 0 for _, place in heap}
    heapq.heapify(heap)
    while heap:
        length, place = heapq.heappop(heap)
        if lengths[place] >= 0:
            continue
        lengths[place] = length
        for by, step in neighbours:
            to = tuple(np.add(place, by))
            if all(0 <= i < n for i, n in zip(to, open_.shape)) and open_[to] and lengths[to] < 0:
                if length + step < best.get(to, length + step + 1):
                    best[to] = length + step
                    heapq.heappush(heap, (length + step, to))
    return lengths


def felt(view, case):
    """Where pads, light curtains and covers feel a body; one that the environment trips says nothing new."""
    global felt_by, stuck
    middles = view["origin_m"] + (np.stack(np.indices(view["truth"].shape), axis=-1) + 0.5) * case["voxel_m"]
    fixed = view["truth"] & ~view["human"] & ~view["robot"]
    all_ = np.zeros(view["truth"].shape, bool)
    for switch in case["switches"]:
        inside = ((middles > switch["low"]) & (middles < switch["high"])).all(axis=-1)
        if (inside & fixed).any() and not switch["tare"]:
            stuck += 1
        else:
            all_ |= inside
            felt_by += inside.any()
    if case["cover_m"] is not None:
        near = distance_transform_edt(~view["robot"]) * case["voxel_m"] <= case["cover_m"]
        all_ |= near & ~view["robot"]
        felt_by += 1
    return all_


def moment(views, case):
    """What is watched, solid and to be kept away from in several snapshots at once."""
    watched = np.logical_and.reduce([(view["labels"] == 0) | view["hits"] | felt(view, case) for view in views])
    solid = np.logical_and.reduce([view["truth"] for view in views])
    if case["region"] is None:
        hazard = np.logical_or.reduce([view["robot"] for view in views])
    else:
        at = list(views[0]["region_names"]).index(case["region"])
        hazard = np.logical_or.reduce([view["regions"][..., at] for view in views])
    # The upper sides of what is neither robot nor person, in any of the snapshots.
    surfaces = np.zeros(solid.shape, bool)
    for view in views:
        for x, y, z in np.argwhere(view["truth"] & ~view["human"] & ~view["robot"]):
            surfaces[x, y, z] |= z + 1 == solid.shape[2] or not view["truth"][x, y, z + 1]
    return watched, solid, hazard, surfaces


def begins_at(entry, body, places, size, grid, origin, voxel_m):
    """Whether a body at each of some places is in an entry."""
    if entry["box"] is None:
        begin = np.zeros(places.shape[:3], bool)
        for r in range(2 if body["on_floor"] else 3):
            begin |= (places[..., r] == 0) | (places[..., r] + size[r] == grid[r])
        return begin
    low, high = np.array(entry["box"])
    least = origin + (places + 0.5) * voxel_m
    most = origin + (places + size - 0.5) * voxel_m
    return ((least > low - 1e-6) & (most < high - 1e-6)).all(axis=-1)


def answer(case, body, entry, watched, solid, hazard, surfaces, origin, voxel_m):
    global climbed, apart
    below = lambda height: int(np.floor((height - origin[2]) / voxel_m + 1e-9))
    floor, layers = below(case["floor_m"]), None
    if body["on_floor"]:
        # From the layer above that of the floor to below its height.
        top = case["floor_m"] + (body["box"][2] if "box" in body else body["cylinder"][1])
        layers = max(1, below(top) - floor - 1)
    voxels, size = body_voxels(body, voxel_m, layers)
    last = np.array(solid.shape) - size
    first = [0, 0, 0]
    if body["on_floor"] and not walks(case, body):
        first[2] = last[2] = floor + 1
    shape = [max(0, last[r] - first[r] + 1) for r in range(3)]
    # Everything about a body is asked voxel by voxel, place by place.
    corner = lambda v: tuple(slice(first[r] + v[r], first[r] + v[r] + shape[r]) for r in range(3))
    count = lambda plane: sum(plane[corner(v)].astype(int) for v in voxels)
    free = count(solid) == 0
    places = np.stack(np.meshgrid(*[np.arange(shape[r]) + first[r] for r in range(3)], indexing="ij"), axis=-1)
    begins = lambda one: begins_at(one, body, places, size, solid.shape, origin, voxel_m)
    begin, neighbours = begins(entry), steps(case, body)
    if walks(case, body):
        # On the layer below the grid nobody stands; below each column of the body there may be a surface.
        raised = np.pad(surfaces, ((0, 0), (0, 0), (1, 0)))
        lowest = [v for v in voxels if not (voxels == v - [0, 0, 1]).all(axis=1).any()]
        free &= sum(raised[corner(v)].astype(int) for v in lowest) > 0
        everywhere = free
        free = dijkstra(np.logical_or.reduce([begins(one) for one in case["entries"]]), free, neighbours) >= 0
        apart += (everywhere & ~free).any()
    open_ = free & (count(watched) < body["min_voxels"])
    lengths = dijkstra(begin, open_, neighbours)
    reached = lengths >= 0
    areas = [plane.sum() * voxel_m**2 if body["on_floor"] else np.nan for plane in (open_, reached)]
    squared = np.rint(distance_transform_edt(~hazard) ** 2).astype(int)
    nearest = np.min([squared[corner(v)] for v in voxels], axis=0)
    first_noticed = nearest[begin & free & ~open_]
    first_noticed = first_noticed.min() if first_noticed.size else np.nan
    if not reached.any():
        return None, first_noticed, areas, "no_room" if np.isnan(first_noticed) else "noticed"
    rank = min((nearest[at], lengths[at], at[::-1], at) for at in map(tuple, np.argwhere(reached)))
    deepest, length, _, at = rank
    longest = max(length for _, length in neighbours)
    fronts = [(lengths[reached] // longest == k).sum() for k in range(1, length // longest)]
    climbed += walks(case, body) and len(set(np.argwhere(reached)[:, 2])) > 1
    middle = origin + (places[at] + size / 2) * voxel_m
    return (deepest, length, middle, min(fronts) if fronts else None), first_noticed, areas, "open"


same = lambda one, other: (pd.isna(one) and pd.isna(other)) or abs(one - other) < 1.1e-5
compared = noticed = nearer = through = felt_by = stuck = climbed = apart = 0
for folder in sorted(Path(sys.argv[1]).iterdir()):
    case = json.loads((folder / "case.json").read_text())
    rows = pd.read_csv(folder / "approach.csv", dtype={"snapshot": str})
    views = {company: [] for company in case["companies"]}
    for company, kept in views.items():
        kept += [np.load(folder / f"{company}-{k}.npz") for k in range(case["snapshots"])]
    voxel_m, origin = case["voxel_m"], views["absent"][0]["origin_m"]
    moments = [str(k) for k in range(case["snapshots"])] + (["*"] if case["snapshots"] > 1 else [])
    expected = list(itertools.product(case["companies"], moments, case["bodies"], case["entries"]))
    assert len(expected) == len(rows), (folder, len(expected), len(rows))
    for (company, when, body, entry), (_, row) in zip(expected, rows.iterrows()):
        what = (folder.name, company, when, body["name"], entry["name"])
        assert what[1:] == (row["people"], row["snapshot"], row["body"], row["entry"]), (what, row)
        of = views[company] if when == "*" else [views[company][int(when)]]
        planes = moment(of, case)
        if case["hazard"] == "robot_swept":
            planes = (*planes[:2], moment(views[company], case)[2], planes[3])
        found, first_noticed, areas, at_entry = answer(case, body, entry, *planes, origin, voxel_m)
        assert same(areas[0], row["unnoticed_m2"]) and same(areas[1], row["joined_m2"]), (what, areas, row)
        assert at_entry == row["at_entry"], (what, at_entry, row)
        assert same(first_noticed, row["noticed_squared"]), (what, first_noticed, row)
        assert same(np.sqrt(first_noticed) * voxel_m, row["noticed_m"]), (what, first_noticed, row)
        nearer += found is not None and first_noticed < found[0]
        compared += 1
        if found is None:
            assert pd.isna(row["deepest_m"]) and pd.isna(row["path_m"]), (what, row)
            noticed += 1
            continue
        deepest, length, middle, front = found
        assert deepest == row["deepest_squared"], (what, found, row)
        assert same(np.sqrt(deepest) * voxel_m, row["deepest_m"]), (what, found, row)
        assert same(length / 1000 * voxel_m, row["path_m"]), (what, found, row)
        assert all(same(middle[r], row["xyz"[r] + "_m"]) for r in range(3)), (what, found, row)
        assert same(np.nan if front is None else front, row["narrowest_places"]), (what, found, row)
        through += front is not None
print(f"numpy {np.__version__}: {compared} rows are equal, {noticed} noticed at the entry, {through} by a way with a narrowest place")
assert compared > 300 and noticed > 20 and nearer > 5 and through > 50, ("the cells are too easy", nearer)
assert climbed > 20 and apart > 20, ("too few steps that are climbed, and that are not", climbed, apart)
assert felt_by > 50 and stuck > 10, ("too few pads, gates and covers", felt_by, stuck)
