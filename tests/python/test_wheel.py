# SPDX-License-Identifier: Apache-2.0
"""The wheel, built without network and installed beside nothing else."""
import subprocess
import sys
import pathlib
import os
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(*command, **environment):
    done = subprocess.run(command, capture_output=True, text=True, cwd="/",
                          env={**os.environ, **environment})
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_wheel_is_built_without_network_installed_and_used(tmp_path):
    run(sys.executable, "-m", "pip", "wheel", "--no-index", "--no-build-isolation", "--no-deps", "-q",
        "--disable-pip-version-check", "--wheel-dir", str(tmp_path), str(ROOT / "clients/python"))
    wheel, = tmp_path.glob("vdrive-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {"vdrive/__init__.py", "vdrive/_vdrive.pyi", "vdrive/py.typed", "vdrive/libvdrive_dds.so"} <= set(names)
    site = tmp_path / "site"
    run(sys.executable, "-m", "pip", "install", "--no-index", "--no-deps", "-q", "--target", str(site),
        "--disable-pip-version-check", "--root-user-action=ignore", str(wheel))
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
""" % str(site))
    output = run(sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(test),
                 PYTHONPATH=str(site))
    assert "2 passed" in output
