"""What computes, as methods take it."""

from __future__ import annotations

import os
from typing import Literal

from . import _perirobot

#: What computes: "auto" is a hardware GPU if there is one, else the CPU. All count the same.
Backend = Literal["auto", "cpu", "gpu", "oracle"]

#: The process that has opened its drivers of GPUs.
_opened: int | None = None


def words(backend: Backend, adapter: str | None, threads: int | None) -> tuple[str, str | None, int | None]:
    """The backend as the compiled half takes it, drivers of GPUs opened if it may need them."""
    global _opened
    if backend in ("auto", "gpu") and _opened != os.getpid():
        _open_drivers()
        _opened = os.getpid()
    return backend, adapter, threads


def _open_drivers() -> None:
    """Mesa's drivers write lines about this variable where it is not set, as in containers; they are of no use."""
    variable = "XDG_RUNTIME_DIR"
    if variable in os.environ:
        _perirobot.open_drivers()
        return
    os.environ[variable] = "/nonexistent"
    try:
        _perirobot.open_drivers()
    finally:
        del os.environ[variable]
