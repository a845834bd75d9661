"""The examples in docstrings run, each docstring by itself, from the project's folder; everything that is called has one."""

import contextlib
import doctest
import inspect
import io
import os
import shutil
import tempfile
import unittest
import warnings
from collections.abc import Iterator

import numpy as np

import perirobot as pr
import perirobot.gym
from shared import ROOT

#: What is returned, not made: its class has its examples where it comes from, and its methods have their own.
RETURNED = {"Approach", "Best", "Dataset", "Labels", "Picture", "Planner", "Purchase", "PurchasedSensor", "PurchasedSet", "Reason"}
RETURNED |= {"Result", "Sample", "ScoredMap", "Table", "Truth", "Why", "DeviceWarning", "InputWarning"}

ENVIRONMENTS = ("PlaceSensors", "PlaceSensorsVector")


def documented() -> Iterator[tuple[str, str, bool]]:
    """Names, docstrings, and whether there must be an example."""
    yield "perirobot", pr.__doc__ or "", True
    for name in pr.__all__:
        found = getattr(pr, name)
        if inspect.isclass(found) or inspect.isfunction(found):
            yield name, inspect.getdoc(found) or "", name not in RETURNED
    for name in ENVIRONMENTS:
        yield f"gym.{name}", inspect.getdoc(getattr(pr.gym, name)) or "", True
    classes = {name: getattr(pr, name) for name in pr.__all__} | {f"gym.{name}": getattr(pr.gym, name) for name in ENVIRONMENTS}
    seen = set()
    for name, found in classes.items():
        for method, routine in inspect.getmembers(found, inspect.isroutine) if inspect.isclass(found) else []:
            is_ours = str(getattr(routine, "__module__", "")).startswith("perirobot")
            if is_ours and not method.startswith("_") and routine.__qualname__ not in seen:
                seen.add(routine.__qualname__)
                yield f"{name}.{method}", inspect.getdoc(routine) or "", True


class Docstrings(unittest.TestCase):
    def test_examples_run(self):
        before = os.getcwd()
        self.addCleanup(os.chdir, before)
        run = 0
        for name, text, is_needed in documented():
            examples = doctest.DocTestParser().get_examples(text)
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                self.assertTrue(examples or not is_needed, "an example is missing")
                shutil.copytree(ROOT / "scenes", f"{folder}/scenes")
                os.chdir(folder)
                names = {"pr": pr, "np": np}
                with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
                    warnings.simplefilter("ignore")
                    for example in examples:
                        exec(compile(example.source, f"<{name}>", "single"), names)
                        run += 1
                os.chdir(before)
        self.assertGreater(run, 130)


if __name__ == "__main__":
    unittest.main()
