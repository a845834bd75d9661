"""Reads the files of `perirobot export` as a user would: the arrays' counts are those of the sweep's results.csv, and the
points lie where the arrays say that something was seen.

The folder and results.csv are named on the command line; tests/documents/export.rs writes them.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd

folder, results = Path(sys.argv[1]), pd.read_csv(sys.argv[2])
view = np.load(folder / "view.npz")
labels, truth, verdict = view["labels"], view["truth"], view["verdict"]
shape = labels.shape
assert labels.dtype == np.int8 and truth.dtype == bool and verdict.dtype == np.uint8
assert set(np.unique(labels)) <= {-1, 0, 1} and labels.size > 0
assert view["origin_m"].shape == (3,) and view["voxel_size_m"].shape == () and view["voxel_size_m"] == 0.1
assert view["hits"].dtype == bool and view["hits"].shape == shape
assert truth.shape == verdict.shape == view["human"].shape == view["robot"].shape == shape
# The room is 2.4 x 1.8 x 1.6 m: x is the first axis, z the last.
assert shape[0] > shape[1] > shape[2], shape
# The floor is below everything but what hangs over the walls.
assert truth[2:-2, 2:-2, :2].any(axis=2).all()

names = list(view["verdict_names"])
assert names == ["tp", "fp", "fn", "tn", "uo", "uf"]
of = {(1, True): "tp", (1, False): "fp", (0, True): "fn", (0, False): "tn", (-1, True): "uo", (-1, False): "uf"}
for (label, there), name in of.items():
    assert (verdict[(labels == label) & (truth == there)] == names.index(name)).all(), name

is_same = [results[key] == view[key].item() for key in ["scene", "combination", "poses", "representation", "snapshot", "repeat"]]
rows = results[np.logical_and.reduce(is_same)].set_index("region")
regions = view["regions"]
assert regions.shape == (*shape, len(rows)) and regions.dtype == bool
assert sorted(view["region_names"]) == sorted(rows.index), (view["region_names"], rows.index)
for r, region in enumerate(view["region_names"]):
    inside = regions[..., r]
    for v, name in enumerate(names):
        assert (inside & (verdict == v)).sum() == rows.loc[region, name], (region, name)
    for who in ["human", "robot"]:
        assert (inside & (verdict == 0) & view[who]).sum() == rows.loc[region, f"tp_{who}"], (region, who)

point = np.dtype([("at", "<f4", 3), ("ray", "<u4"), ("verdict", "u1")])
for ply in folder.glob("points-*.ply"):
    head, body = ply.read_bytes().split(b"end_header\n", 1)
    points = np.frombuffer(body, point)
    assert f"element vertex {len(points)}\n" in head.decode("ascii") and len(points) > 0
    head, body = ply.with_suffix(".pcd").read_bytes().split(b"DATA binary\n", 1)
    cloud, head = np.frombuffer(body, point), head.decode("ascii")
    assert (cloud[["ray", "verdict"]] == points[["ray", "verdict"]]).all() and f"\nPOINTS {len(points)}\n" in head
    # PCL moves the points by the viewpoint: a place, and a quaternion w, x, y, z.
    (*place, w, x, y, z) = map(float, next(l for l in head.splitlines() if l.startswith("VIEWPOINT")).split()[1:])
    axis = np.array([x, y, z])
    turned = cloud["at"] + 2 * np.cross(axis, np.cross(axis, cloud["at"]) + w * cloud["at"])
    assert np.abs(turned + place - points["at"]).max() < 1e-5 and np.abs(cloud["at"] - points["at"]).max() > 0.1
    assert (np.diff(points["ray"].astype(int)) > 0).all()
    # A point is on the near side of its voxel: one of the voxels that it touches has its verdict.
    at = (points["at"] - view["origin_m"]) / view["voxel_size_m"]
    found = np.zeros(len(points), bool)
    for corner in np.ndindex(3, 3, 3):
        cell = np.floor(at + (np.array(corner) - 1) * 2e-3).astype(int).clip(0, np.array(shape) - 1)
        found |= verdict[tuple(cell.T)] == points["verdict"]
    assert found.all(), (ply.name, points[~found][:3])
print(f"numpy {np.__version__}: {shape}, {len(rows)} regions are equal")
