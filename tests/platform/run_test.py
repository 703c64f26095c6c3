#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Mistakes in calls of run.sh, and deploy/setup.sh on a system whose packages it does not know."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(*command, **environment):
    done = subprocess.run(command, text=True, capture_output=True, timeout=60, env={**os.environ, **environment},
                          check=False)
    return done.returncode, done.stdout + done.stderr


class RunOnAPlatform(unittest.TestCase):
    def test_refuses_each_wrong_argument_in_one_line_and_makes_no_root(self):
        for words, told in (((), "which release?"), (("sid",), "'sid' is no release"), (("trixie", "--ful"), "'--ful'"),
                            (("trixie", "bookworm"), "'trixie' or 'bookworm'"), (("trixie", "--cache"), "--cache needs a value"),
                            (("trixie", "--full", "--check"), "--full and --check"),
                            (("trixie", "--mirror", "debian.org"), "--mirror 'debian.org': must be a URL")):
            with self.subTest(words=words), tempfile.TemporaryDirectory() as folder:
                code, text = run(ROOT / "tests/platform/run.sh", *words, TMPDIR=folder)
                self.assertEqual((code, text.count("\n"), os.listdir(folder)), (2, 1, []), text)
                self.assertIn(told, text)

    def test_is_skipped_where_tests_run_sh_has_no_time_for_it(self):
        code, text = run(ROOT / "tests/platform/run.sh", "trixie", "--check", VDRIVE_SKIPPED=" check")
        self.assertEqual((code, text), (77, "platform: --check is skipped by tests/run.sh\n"))


class Setup(unittest.TestCase):
    @unittest.skipUnless(shutil.which("bwrap"), "no bubblewrap to show it another system")
    def test_on_another_system_names_it_and_what_it_needs_and_installs_nothing(self):
        for release, told in (('ID=ubuntu\nVERSION_ID="24.04"\nPRETTY_NAME="Ubuntu 24.04.1 LTS"\n', "Ubuntu 24.04.1 LTS"),
                              ("", "a system without a name")):
            with self.subTest(told=told), tempfile.NamedTemporaryFile("w") as file:
                file.write(release)
                file.flush()
                code, text = run("bwrap", "--ro-bind", "/", "/", "--dev", "/dev", "--ro-bind", file.name,
                                 os.path.realpath("/etc/os-release"), ROOT / "deploy/setup.sh", "--tests")
                self.assertEqual((code, text.count("\n")), (1, 1), text)
                for part in (f"this is {told}.", "Debian 12 and 13", "Fast DDS 2.9 or 3.1", "CMake 3.25"):
                    self.assertIn(part, text)


if __name__ == "__main__":
    unittest.main()
