"""The command `perirobot`, the same as the one that cargo installs."""

import os
import signal
import sys

from . import _perirobot


def main() -> None:
    """Runs the command line in ``sys.argv`` and exits with its code."""
    # The program answers Ctrl-C itself: the batch under way is finished first.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # STEP files are converted by the packages of this interpreter.
    if sys.executable:
        os.environ.setdefault("PERIROBOT_PYTHON", sys.executable)
    sys.exit(_perirobot.run(["perirobot", *sys.argv[1:]]))
