# SPDX-License-Identifier: Apache-2.0
"""When the module loads the DDS library, and the error where it cannot."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import textwrap

import vdrive

LIBRARY = "libvdrive_dds.so"
FAST_DDS = ("libfastrtps", "libfastdds")  # 2.9, 3.1
OF_DDS = (*FAST_DDS, "libtinyxml2", LIBRARY)  # not libcrypto, which numpy loads, too


def run(program, **environment):
    """Run a Python program in its own process; return its output."""
    finished = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], timeout=120,
                              capture_output=True, text=True, env={**os.environ, **environment})
    assert finished.returncode == 0, finished.stderr
    return finished.stdout


def test_the_dds_library_is_loaded_when_a_session_over_dds_is_made():
    run(f"""
        import vdrive

        def loaded():
            with open("/proc/self/maps", encoding="utf-8") as maps:
                text = maps.read()
            assert "_vdrive" in text
            return [name for name in {OF_DDS} if name in text]

        assert not loaded()
        with vdrive.Bench(axes=1) as bench, bench.session() as session:
            session.axis("1.1").enable()
        assert not loaded()
        # Both in one process, and twice each: the second session finds the library loaded.
        for _ in range(2):
            with vdrive.Bench(axes=1, over="dds") as remote, remote.session() as over_dds, \\
                    vdrive.Bench(axes=1) as bench, bench.session() as session:
                for each in (over_dds, session):
                    axis = each.axis("1.1")
                    axis.enable()
                    axis.move_to(1000)
                    assert axis.status().position == 1000
        assert len(loaded()) == 3, loaded()  # one version of Fast DDS
    """)


def test_numpy_and_asyncio_are_loaded_when_they_are_used():
    """These modules take most of the run time of a short program."""
    run("""
        import sys
        import vdrive

        def is_loaded(name):
            return name in sys.modules

        with vdrive.Bench(axes=1) as bench, bench.session() as session:
            axis = session.axis("1.1")
            axis.enable()
            axis.move_to(1000)
            assert not is_loaded("numpy") and not is_loaded("asyncio")
            assert session.record(ticks=3)["position"].shape == (3, 1)
            assert is_loaded("numpy") and not is_loaded("asyncio")
            stream = session.follow_async()
            assert not is_loaded("asyncio"), "it is loaded by who awaits"
            stream.close()
    """)


def test_threads_may_meet_in_their_first_array():
    """pybind11 imports numpy under a guard, where two threads could deadlock."""
    run("""
        import sys
        import threading
        import vdrive

        THREADS = 4
        together = threading.Barrier(THREADS)
        shapes = []

        def first_array():
            with vdrive.Bench(axes=1) as bench, bench.session() as session:
                together.wait()
                shapes.append(session.record(ticks=2)["position"].shape)

        sys.setswitchinterval(1e-6)
        threads = [threading.Thread(target=first_array) for _ in range(THREADS)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert shapes == [(2, 1)] * THREADS, shapes
    """)


def test_an_error_of_the_dds_library_keeps_its_text():
    output = run("""
        import vdrive
        try:
            vdrive.Session(domain=1, interfaces=["192.0.2.1"])
        except vdrive.ConfigurationError as error:
            print(error)
    """)
    assert "192.0.2.1" in output and "no active interface has this address" in output


def test_a_library_of_another_build_is_refused_by_name(tmp_path):
    package = tmp_path / "vdrive"
    shutil.copytree(pathlib.Path(vdrive.__file__).parent, package,
                    ignore=shutil.ignore_patterns("__pycache__"))
    library = package / LIBRARY
    build = re.compile(rb"vdrive \d+\.\d+\.\d+ build [0-9a-f]{16}(?=\0)")
    own = build.findall(library.read_bytes())
    assert len(own) == 1
    other = own[0][:-16] + b"0123456789abcdef"
    library.write_bytes(library.read_bytes().replace(own[0], other))
    output = run("""
        import vdrive
        with vdrive.Bench(axes=1) as bench, bench.session() as session:
            session.axis("1.1").enable()
        for _ in range(2):
            try:
                vdrive.Session(domain=1)
            except vdrive.ConfigurationError as error:
                print(error)
    """, PYTHONPATH=str(tmp_path))
    lines = output.splitlines()
    assert len(lines) == 2 and lines[0] == lines[1]
    assert f'{library} was built as "{other.decode()}"' in lines[0]
    assert f'{package / "_vdrive"}' in lines[0] and own[0].decode() in lines[0]
    assert "Install both from one build" in lines[0]


def test_a_module_without_the_library_has_benches_and_says_what_a_session_over_dds_needs(tmp_path):
    package = pathlib.Path(vdrive.__file__).parent
    shutil.copytree(package, tmp_path / "vdrive", ignore=shutil.ignore_patterns(LIBRARY, "__pycache__"))
    output = run("""
        import vdrive
        with vdrive.Bench(axes=1) as bench, bench.session() as session:
            session.axis("1.1").enable()
        for _ in range(2):
            try:
                vdrive.Session(domain=1)
            except vdrive.ConfigurationError as error:
                print(error)
    """, PYTHONPATH=str(tmp_path))
    lines = output.splitlines()
    assert len(lines) == 2 and lines[0] == lines[1]
    assert str(tmp_path / "vdrive" / LIBRARY) in lines[0] and any(name in lines[0] for name in FAST_DDS)


def test_a_package_of_another_python_says_for_which_it_is_and_how_to_build_it_for_this_one(tmp_path):
    package = tmp_path / "vdrive"
    shutil.copytree(pathlib.Path(vdrive.__file__).parent, package,
                    ignore=shutil.ignore_patterns("__pycache__"))
    module = next(package.glob("_vdrive.*.so"))
    module.rename(package / "_vdrive.cpython-37-x86_64-linux-gnu.so")
    read = """
        try:
            import vdrive
        except ImportError as error:
            print(error)
    """
    this = f"but this is Python {sys.version_info.major}.{sys.version_info.minor} ({sys.executable})"
    said = run(read, PYTHONPATH=str(tmp_path))
    assert f"{package} is built for Python 3.7, {this}" in said
    assert f"-D VDRIVE_PYTHON={sys.executable}" in said
    (package / "_vdrive.cpython-37-x86_64-linux-gnu.so").unlink()
    assert f"is built for no Python at all, {this}" in run(read, PYTHONPATH=str(tmp_path))
    # A module of this Python version that fails to load reports the reason of the loader.
    (package / module.name).write_bytes(b"no module")
    assert "built for" not in run(read, PYTHONPATH=str(tmp_path))
