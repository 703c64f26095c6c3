# SPDX-License-Identifier: Apache-2.0
"""The wheel, built without a network and installed without anything else of vdrive."""
import os
import pathlib
import re
import subprocess
import sys
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Libraries that every Debian with Python has.
EVERYWHERE = re.compile(r"linux-vdso|ld-linux|lib(c|gcc_s|m|stdc\+\+|z)\.so")


def run(*command, **environment):
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, capture_output=True, text=True, cwd="/", env={**kept, **environment}, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def pip(*words):
    return run(sys.executable, "-m", "pip", "--disable-pip-version-check", "-q", *words)


def test_a_wheel_is_built_without_network_installed_and_used(tmp_path):
    pip("wheel", "--no-index", "--no-build-isolation", "--no-deps", "--wheel-dir", str(tmp_path), str(ROOT / "clients/python"))
    wheel, = tmp_path.glob("vdrive-*.whl")
    version = f"cp{sys.version_info.major}{sys.version_info.minor}"
    assert wheel.name.endswith(f"-{version}-{version}-linux_{os.uname().machine}.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {"vdrive/__init__.py", "vdrive/_vdrive.pyi", "vdrive/py.typed", "vdrive/libvdrive_dds.so"} <= set(names)

    # The interpreter, numpy and pytest of the system, without vdrive.
    venv = tmp_path / "venv"
    run(sys.executable, "-m", "venv", "--without-pip", "--system-site-packages", str(venv))
    pip("--python", str(venv / "bin/python"), "install", "--no-index", "--no-deps", "--root-user-action=ignore", str(wheel))
    module, = venv.glob("lib/python*/site-packages/vdrive/_vdrive.*.so")
    needed = run("ldd", str(module)).splitlines()
    others = [line for line in needed if str(module.parent) not in line and not EVERYWHERE.search(line)]
    assert others == [], "a bench in the process needs libraries that the wheel does not have"
    assert not any(re.search("lib(fast|tinyxml2|crypto)", line) for line in needed)

    test = tmp_path / "test_ten_lines.py"
    test.write_text("""
import pytest
import vdrive

@pytest.mark.parametrize("over", ["local", pytest.param("dds", marks=pytest.mark.vdrive(over="dds"))])
def test_it_gets_there(vdrive_session, over):
    assert vdrive.__file__.startswith(%r)
    axis = vdrive_session.axis("1.1")
    axis.enable()
    axis.move_to(10000, velocity=20000)
    assert axis.status().position == 10000
""" % str(venv))
    pytest = (str(venv / "bin/python"), "-m", "pytest", "-q", "-p", "no:cacheprovider", str(test))
    assert "2 passed" in run(*pytest)
    alone = dict(VDRIVE_SERVICE="/nonexistent", VDRIVE_TOOL="/nonexistent")
    assert "1 passed" in run(*pytest, "-k", "local", **alone)
