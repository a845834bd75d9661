"""Converts the STEP file mesh.step of the working folder to mesh.glb by cascadio (OpenCASCADE)."""

import sys

try:
    import cascadio
except ModuleNotFoundError as missing:
    print(missing)
    sys.exit(77)

# The file's unit becomes metres; the chord error is in millimetres, the angle between chords in radians.
failed = cascadio.step_to_glb("mesh.step", "mesh.glb", tol_linear=1.0, tol_angular=0.5)
sys.exit(1 if failed else 0)
