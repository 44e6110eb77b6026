"""bench/peers/python_peers.py with a mock peer: its processes after the caller has ended."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])
# Without packages: empty arrays, and a peer that is made at once.
CALL = """
import sys, types
import python_peers
python_peers.numpy = types.SimpleNamespace(int32=0, float64=0, fromfile=lambda *_: types.SimpleNamespace(reshape=lambda *_: None))
python_peers.PEERS["none"] = lambda *_: None
python_peers.serve("none", "mode", "1", sys.argv[1])
"""


class PythonPeers(unittest.TestCase):
    def serve(self, folder, answers):
        return subprocess.run([sys.executable, "-c", CALL, folder], input="start\n", stdout=answers, stderr=subprocess.PIPE, text=True, check=False,
                              env=os.environ | {"PYTHONPATH": str(ROOT / "bench/peers")}, timeout=60)

    def test_the_folder_goes_with_the_last_line(self):
        with tempfile.TemporaryDirectory() as outer:
            folder = pathlib.Path(outer) / "exchange"
            folder.mkdir()
            done = self.serve(folder, subprocess.PIPE)
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "ready\n", ""))
            self.assertFalse(folder.exists())

    def test_a_caller_that_was_killed_leaves_no_folder_and_no_traceback(self):
        nobody, answers = os.pipe()
        os.close(nobody)
        with tempfile.TemporaryDirectory() as outer, os.fdopen(answers, "w") as pipe:
            folder = pathlib.Path(outer) / "exchange"
            folder.mkdir()
            done = self.serve(folder, pipe)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertFalse(folder.exists())


if __name__ == "__main__":
    unittest.main()
