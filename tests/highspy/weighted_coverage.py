"""Solves questions of weighted coverage by HiGHS and compares with what is claimed of them.

A file of the folder has the voxels of a region, which candidates are right about each, which sets of candidates are
allowed, and the claimed highest F1 as a fraction p/q. F1 of a set is above p/q just if (2q - p) TP + p TN > p s, s
being the voxels of the region. So the largest value of the left side must be p s: at the claimed score a set exists,
just above it none does. Values are added up again as whole numbers; tests/choose/mip.rs writes the files.
"""

import json
import sys
from collections import Counter
from pathlib import Path

import highspy


def largest(cell, weights):
    """The largest weight of what an allowed set is right about: that of a set, and what no set is above."""
    h = highspy.Highs()
    h.silent()
    h.setOptionValue("mip_rel_gap", 0.0)
    h.setOptionValue("mip_abs_gap", 0.5)
    candidates = range(len(cell["cost"]))
    x = [h.addBinary() for _ in candidates]
    h.addConstr(sum(x) <= cell["at_most"])
    if cell["budget"] is not None:
        h.addConstr(sum(cell["cost"][i] * x[i] for i in candidates) <= cell["budget"])
    for sensor, most in cell["sensors"]:
        h.addConstr(sum(x[i] for i in sensor) <= most)
    for a, b in cell["near"]:
        h.addConstr(x[a] + x[b] <= 1)
    terms = []
    for right, weight in weights.items():
        y = h.addVariable(0, 1)
        h.addConstr(y <= sum(x[i] for i in right))
        terms.append(weight * y)
    h.maximize(sum(terms))
    assert h.getModelStatus() == highspy.HighsModelStatus.kOptimal, h.getModelStatus()
    chosen = {i for i in candidates if h.val(x[i]) > 0.5}
    assert len(chosen) <= cell["at_most"]
    assert cell["budget"] is None or sum(cell["cost"][i] for i in chosen) <= cell["budget"]
    assert all(len(chosen & set(sensor)) <= most for sensor, most in cell["sensors"])
    assert not any(a in chosen and b in chosen for a, b in cell["near"])
    found = sum(weight for right, weight in weights.items() if chosen.intersection(right))
    return found, h.getInfo().mip_dual_bound


wrong, count = [], 0
for path in sorted(Path(sys.argv[1]).glob("*.json")):
    cell = json.loads(path.read_text())
    p, q = cell["f1"]
    weights = Counter()
    for truth, weight in [("occupied", 2 * q - p), ("free", p)]:
        for right in cell[truth]:
            weights[tuple(right)] += weight
    weights.pop((), None)
    voxels = len(cell["occupied"]) + len(cell["free"])
    found, bound = largest(cell, weights)
    if found < p * voxels:
        wrong.append(f"{path.name}: {p}/{q} is claimed, and no set reaches it: {found} of {p * voxels}")
    elif found > p * voxels or bound >= p * voxels + 1:
        wrong.append(f"{path.name}: {p}/{q} is claimed, and a set is above: {found}, {bound} of {p * voxels}")
    count += 1
assert not wrong, "\n".join(wrong)
assert count == int(sys.argv[2]), count
