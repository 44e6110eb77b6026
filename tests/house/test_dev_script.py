"""./dev: its help, its exit codes, and what it does about missing packages. Stand-ins for apt and sudo only record."""

import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(os.environ["PALPATE_SOURCE_DIR"])


class DevScript(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="palpate dev ")
        self.addCleanup(folder.cleanup)
        self.home = pathlib.Path(folder.name)
        (self.home / "bin").mkdir()
        # A copy, so that its build folder and log are not ours.
        (self.home / "dev").write_bytes((ROOT / "dev").read_bytes())
        (self.home / "dev").chmod(0o755)

    def stand_in(self, name, body):
        file = self.home / "bin" / name
        file.write_text(f"#!/bin/bash\n{body}\n")
        file.chmod(0o755)

    def dev(self, *arguments):
        environment = dict(os.environ, PATH=f"{self.home / 'bin'}:{os.environ['PATH']}", CALLS=str(self.home / "calls"))
        return subprocess.run([self.home / "dev", *arguments], cwd="/", env=environment, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, timeout=60)

    def calls(self):
        file = self.home / "calls"
        return file.read_text() if file.exists() else ""

    def nothing_installed(self, user, sudo_status):
        self.stand_in("id", f"echo {user}")
        self.stand_in("dpkg-query", "exit 1")
        self.stand_in("apt-get", 'echo "apt-get $*" >> "$CALLS"')
        self.stand_in("sudo", f'echo "sudo $*" >> "$CALLS"; [[ {sudo_status} == 0 ]] || exit {sudo_status}; '
                              '[[ $1 == -n ]] || "$@"')

    def test_help_names_every_command(self):
        result = self.dev("help")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        for command in ["run", "test", "check", "lint", "palpate", "python", "build", "wheel", "bench", "fuzz", "coverage", "docs", "reliability", "format", "setup",
                        "help"]:
            self.assertRegex(result.stdout, rf"(?m)^  {command}\b")

    def test_bad_usage_is_one_line_and_2(self):
        for arguments, words in [
            (["nonsense"], "there is no command 'nonsense'"),
            (["test", "--preset", "fast"], "there is no preset 'fast'"),
            (["test", "-R", "mesh", "--preset=slow"], "there is no preset 'slow'"),
            (["test", "--preset"], "--preset needs a name"),
            (["setup", "now"], "'setup' takes no arguments, found 'now'"),
            (["bench", "--fast"], "bench takes --quick, --full and --compare OLD [NEW], found '--fast'"),
            (["bench", "--compare"], "--compare needs a report"),
            (["bench", "--compare", "nowhere.json"], "there is no file '/nowhere.json'"),
            (["bench", "instructions", "--fast"], "bench instructions takes --keep, found '--fast'"),
            (["wheel", "now"], "wheel takes --python PY and --arch aarch64, found 'now'"),
            (["wheel", "--python"], "--python needs a Python"),
            (["wheel", "--arch", "arm"], "--arch takes aarch64, found 'arm'"),
            (["docs", "now"], "'docs' takes no arguments, found 'now'"),
            (["build", "all"], "'build' takes no arguments, found 'all'"),
        ]:
            with self.subTest(arguments=arguments):
                result = self.dev(*arguments)
                self.assertEqual((result.returncode, result.stdout), (2, ""))
                self.assertIn(words, result.stderr)
                self.assertEqual(result.stderr.count("\n"), 1)

    def test_without_rights_it_names_what_is_missing_in_one_line(self):
        self.nothing_installed(user=1000, sudo_status=1)
        for command in ["setup", "test", "run"]:
            with self.subTest(command=command):
                result = self.dev(command)
                self.assertEqual((result.returncode, result.stdout), (2, ""))
                self.assertEqual(result.stderr.count("\n"), 1)
                self.assertRegex(result.stderr, r"run: sudo apt-get install .*g\+\+ cmake .*libvtk9-dev .*libgtest-dev")
        self.assertNotIn("apt-get", self.calls())

    def test_long_tests_have_the_packages_that_they_would_skip_without(self):
        self.nothing_installed(user=1000, sudo_status=1)
        needed = {"slurmctld", "slurmd", "slurm-client", "mmdebstrap"}
        self.assertLessEqual(needed, set(self.dev("test", "--long").stderr.split()))
        self.assertTrue(needed.isdisjoint(self.dev("test").stderr.split()))

    def test_root_and_sudo_install_what_is_missing_and_say_why(self):
        for user, prefix in [(0, "apt-get"), (1000, "sudo env DEBIAN_FRONTEND=noninteractive apt-get")]:
            with self.subTest(user=user):
                self.nothing_installed(user=user, sudo_status=0)
                result = self.dev("setup")
                self.assertEqual((result.returncode, result.stdout), (0, ""))
                self.assertIn("libvtk9-dev (mesh and result files)", result.stderr)
                self.assertIn(prefix, self.calls())
                self.assertRegex(self.calls(), r"apt-get .*install --no-install-recommends --no-remove .*libvtk9-dev")

    def test_only_what_is_missing_is_installed(self):
        self.nothing_installed(user=0, sudo_status=0)
        self.stand_in("dpkg-query", 'for p in "$@"; do [[ $p == cmake ]] || printf "installed=%s " "$p"; done; exit 1')
        result = self.dev("setup")
        self.assertEqual(result.returncode, 0)
        self.assertRegex(self.calls(), r"install --no-install-recommends --no-remove cmake\n")

    def test_a_failing_apt_shows_its_log_and_is_1(self):
        self.nothing_installed(user=0, sudo_status=0)
        self.stand_in("apt-get", 'echo "E: no such thing as a network"; exit 100')
        result = self.dev("setup")
        self.assertEqual((result.returncode, result.stdout), (1, ""))
        self.assertIn("E: no such thing as a network", result.stderr)
        self.assertIn("could not install", result.stderr)

    def test_nothing_missing_is_silent_and_calls_nothing(self):
        self.nothing_installed(user=0, sudo_status=0)
        self.stand_in("dpkg-query", 'for p in "$@"; do printf "installed=%s " "$p"; done')
        result = self.dev("setup")
        self.assertEqual((result.returncode, result.stdout, result.stderr, self.calls()), (0, "", "", ""))

    def test_a_ct_scene_without_its_ct_names_the_analytic_one(self):
        self.stand_in("dpkg-query", 'for p in "$@"; do printf "installed=%s " "$p"; done')
        self.stand_in("cmake", "exit 0")
        self.stand_in("apt-get", 'echo "E: no such thing as a network"; exit 100')
        for scene, stand_in in [("scenes/eye-ct.json", "scenes/eye.json"), ("skull-ct.json", "scenes/skull.json"),
                                ("scenes/jaw-ct.json", "scenes/skull.json"), ("scenes/orbit-ct.json", "scenes/orbit-repair.json")]:
            with self.subTest(scene=scene):
                if pathlib.Path("/usr/share/doc/invesalius-examples/examples/Cranium.inv3").exists() and "jaw" not in scene:
                    self.skipTest("the CT is installed on this machine")
                result = self.dev("run", scene)
                self.assertEqual((result.returncode, result.stdout), (1, ""))
                self.assertIn(f"{stand_in} is the scene from analytic shapes", result.stderr.splitlines()[-1])


if __name__ == "__main__":
    unittest.main()
