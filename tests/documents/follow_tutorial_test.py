#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""follow_tutorial.py finds each mistake.

Shell scripts replace vdrived, which runs until it is ended, and vdrive, which prints its arguments
and its domain.
"""
import pathlib
import tempfile
import textwrap
import unittest

import follow_tutorial

VDRIVED = """#!/bin/bash
exec sleep 60
"""
VDRIVE = """#!/bin/bash
case $1 in
  fail) echo "vdrive: axis 1.1 shows error 0x8611, 12 of 34"; exit 1 ;;
  *) echo "domain $VDRIVE_DOMAIN: $*" ;;
esac
"""
README = """## Other lines
```
false
```
## Twelve lines
```
./deploy/build.sh
export PATH=$PWD/build/release/bin:$PATH
vdrived &                # a service
ls clients/scenarios > /dev/null
vdrive fail              # ends in fault 0x8611
```
"""
START = """```sh
./deploy/build.sh
export VDRIVE_DOMAIN=7
vdrived --log-level error &
```
"""
END = """```sh
kill '%vdrived --log-level'; wait '%vdrived --log-level' || true
```
"""
DOMAIN_OF_README = 91
DOMAIN = 92


def sh(text, note=""):
    return (f"<!-- {note} -->\n" if note else "") + f"```sh\n{textwrap.dedent(text)}```\n"


class Tutorial(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tree = pathlib.Path(folder.name)
        (self.tree / "clients/scenarios").mkdir(parents=True)
        for name, text in (("vdrived", VDRIVED), ("vdrive", VDRIVE)):
            (self.tree / name).write_text(text, encoding="utf-8")
            (self.tree / name).chmod(0o755)

    def findings(self, middle, end=END, readme=README):
        tutorial = follow_tutorial.with_domain(START + middle + end, DOMAIN)
        with follow_tutorial.shell_in_tree(self.tree, self.tree, DOMAIN_OF_README) as shell:
            return "\n".join(follow_tutorial.follow(shell, readme, tutorial))

    def test_commands_with_the_output_that_is_shown_pass(self):
        self.assertEqual(self.findings(sh("""\
            $ vdrive list
            domain 92: list
            $ vdrive fail
            vdrive: axis 1.1 shows ..., 12 of 34
            """)), "")

    def test_another_output_is_found(self):
        self.assertIn("shown:  domain 92: lost\n", self.findings(sh("""\
            $ vdrive list
            domain 92: lost
            """)))

    def test_a_line_that_is_not_shown_is_found(self):
        self.assertIn("actual: domain 92: list", self.findings(sh("$ vdrive list\n")))

    def test_a_command_that_fails_is_found(self):
        self.assertIn("$ vdrive fail\n  exit code 1: vdrive: axis 1.1",
                      self.findings(sh("vdrive fail\n")))

    def test_a_failure_that_does_not_come_is_found(self):
        self.assertIn("exit code 0", self.findings(sh("""\
            $ echo vdrive: failed
            vdrive: failed
            """)))

    def test_numbers_are_compared_unless_they_may_differ(self):
        text = """\
            $ echo '1.1  25.002 mm -7 0x637'
            1.1       24.999 mm 0 0x637
            """
        self.assertIn("actual: 1.1  25.002", self.findings(sh(text)))
        self.assertEqual(self.findings(sh(text, "numbers may differ")), "")
        self.assertIn("actual: 1.1  25.002",
                      self.findings(sh(text.replace("0 0x637", "0 0x250"), "numbers may differ")))

    def test_a_file_is_written_by_its_command(self):
        self.assertEqual(self.findings(sh("""\
            cat > first.scn << 'EOF'
            # kept as it is: $HOME

            enable 1.1
            EOF
            """) + sh("""\
            $ cat first.scn
            # kept as it is: $HOME

            enable 1.1
            """)), "")

    def test_a_process_that_is_no_job_of_the_shell_is_not_ended(self):
        for command in ("kill $!; wait", "kill 1234567", "killall vdrived", "pkill -f vdrived"):
            self.assertIn(f"$ {command}\n  ends what is no job", self.findings(sh(f"{command}\n")))

    def test_the_end_of_the_service_of_the_readme_is_found(self):
        self.assertIn("the service of the README",
                      self.findings(sh("kill '%vdrived >'; wait '%vdrived >' || true\n")))

    def test_a_service_that_is_left_is_found(self):
        self.assertIn("the service of the README", self.findings("", end=""))

    def test_a_failure_in_the_readme_is_found(self):
        readme = README.replace("ls clients", "vdrive list; false\nls clients")
        self.assertIn("$ vdrive list; false\n  exit code 1", self.findings("", readme=readme))

    def test_the_tutorial_has_one_domain_and_commands(self):
        for text in ("export VDRIVE_DOMAIN=7\nexport VDRIVE_DOMAIN=8\n", "vdrive list\n"):
            with self.assertRaisesRegex(SystemExit, "must be one"):
                follow_tutorial.with_domain(text, DOMAIN)
        with follow_tutorial.shell_in_tree(self.tree, self.tree, DOMAIN_OF_README) as shell:
            self.assertEqual(follow_tutorial.follow(shell, README, "```\nno command\n```\n"),
                             ["the tutorial has no command"])


if __name__ == "__main__":
    unittest.main()
