"""``python -m perirobot`` is the command `perirobot`."""

from .program import main

main()
