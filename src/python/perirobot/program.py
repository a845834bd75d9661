"""The command `perirobot`, the same as the one that cargo installs."""

import signal
import sys

from . import _perirobot


def main() -> None:
    """Runs the command line in ``sys.argv`` and exits with its code."""
    # The program answers Ctrl-C itself: the batch under way is finished first.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_perirobot.run(["perirobot", *sys.argv[1:]]))
