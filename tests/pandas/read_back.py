"""Reads table.parquet and table.csv of a folder as a user would, and checks names, types and values.

What the table holds is written by tests/sweep/pandas.rs.
"""

import math
import sys
from pathlib import Path

import pandas as pd

ROWS = 200_000  # more than one row group

folder = Path(sys.argv[1])
parquet = pd.read_parquet(folder / "table.parquet")
# An empty text is a text; only a score may be missing.
csv = pd.read_csv(folder / "table.csv", keep_default_na=False, na_values={"f1": [""]})

for name, frame in {"parquet": parquet, "csv": csv}.items():
    assert list(frame.columns) == ["scene", "tp", "poses", "f1"], (name, frame.columns)
    assert len(frame) == ROWS, (name, len(frame))
    for column, expected in {"scene": "str", "tp": "int64", "poses": "str", "f1": "float64"}.items():
        assert frame[column].dtype == expected, (name, column, frame[column].dtype)
    assert frame["tp"].tolist() == [i * i for i in range(ROWS)], name
    assert frame["scene"].tolist() == [["a, \"b\"", "Straße", ""][i % 3] for i in range(ROWS)], name
    assert frame["poses"].tolist() == [f"camera:wall/{i // 10}" for i in range(ROWS)], name
    for i, f1 in enumerate(frame["f1"]):
        assert math.isnan(f1) if i % 7 == 0 else f1 == 1 / i, (name, i, f1)

pd.testing.assert_frame_equal(parquet, csv, check_exact=True)
print(f"pandas {pd.__version__}: {ROWS} rows are equal")
