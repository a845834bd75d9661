"""The notebook of the guide runs, cell by cell, as a notebook would run it and show what each cell returns."""

import ast
import contextlib
import io
import json
import os
import shutil
import tempfile
import unittest
import warnings

from shared import ROOT


def run(source: str, names: dict) -> object:
    """Runs a cell; the value of its last line, if that is an expression."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "<cell>", "exec"), names)
    return None if last is None else eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)


class Notebook(unittest.TestCase):
    def test_cells_run_in_their_order(self):
        notebooks = sorted(ROOT.glob("src/guide/*.ipynb"))
        self.assertTrue(notebooks)
        before = os.getcwd()
        self.addCleanup(os.chdir, before)
        for path in notebooks:
            notebook, names, shown = json.loads(path.read_text()), {}, 0
            self.assertEqual([notebook["nbformat"], notebook["nbformat_minor"]], [4, 5])
            with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
                warnings.simplefilter("ignore")
                shutil.copytree(ROOT / "scenes", f"{folder}/scenes")
                os.chdir(folder)
                for number, cell in enumerate(notebook["cells"]):
                    if cell["cell_type"] != "code":
                        continue
                    self.assertEqual([cell["outputs"], cell["execution_count"]], [[], None], "clear the outputs")
                    with self.subTest(notebook=path.name, cell=number), contextlib.redirect_stdout(io.StringIO()):
                        value = run("".join(cell["source"]), names)
                        if value is not None:
                            for way in ("_repr_html_", "_repr_png_", "_repr_svg_", "__repr__"):
                                getattr(value, way, lambda: None)()
                            shown += 1
                os.chdir(before)
            self.assertGreater(shown, 3)


if __name__ == "__main__":
    unittest.main()
