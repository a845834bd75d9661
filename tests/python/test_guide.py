"""The blocks of the README and the guide that need the Python package run, each by itself, from the project's folder."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from shared import ROOT

BLOCK = re.compile(r"^```python wheel\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class Guide(unittest.TestCase):
    def test_blocks_run(self):
        run = 0
        for page in [ROOT / "README.md", *sorted(ROOT.glob("src/guide/*.md"))]:
            for block in BLOCK.finditer(page.read_text()):
                line = page.read_text()[: block.start()].count("\n") + 1
                with self.subTest(page=page.name, line=line), tempfile.TemporaryDirectory() as folder:
                    shutil.copytree(ROOT / "scenes", pathlib.Path(folder) / "scenes")
                    command = [sys.executable, "-c", block.group(1)]
                    path = f"{pathlib.Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
                    environment = {**os.environ, "PATH": path}
                    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
                    self.assertEqual(done.returncode, 0, done.stderr)
                run += 1
        self.assertGreaterEqual(run, 4)
