# SPDX-License-Identifier: Apache-2.0
"""Builds the wheel (PEP 517): CMake builds the module, the standard library of Python packs it.

The wheel contains the libraries that the module needs and that not every Linux has, next to the module, which finds
them there (INSTALL_RPATH). The DDS library is not included: only a session over DDS loads it, from the system. The tag
is plain linux, because the wheel is for the Debian on which it was built and later ones, not for every distribution.

Needs deploy/setup.sh --python. VDRIVE_BUILD_DIR names a configured build directory to use instead of
the one of the preset release.
"""
import base64
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
# Needed by the interpreter itself, or installed by apt.
EVERYWHERE = ("ld-linux", "libc.so", "libgcc_s.so", "libm.so", "libstdc++.so", "libz.so")


def _built_package():
    """Build the module; return the directory with the package and its metadata."""
    chosen = os.environ.get("VDRIVE_BUILD_DIR")
    if chosen:
        command = ["cmake", "--build", chosen, "--target", "vdrive_python"]
    else:
        command = [ROOT / "deploy/build.sh", "--target", "vdrive_python", "-D", "VDRIVE_BUILD_PYTHON=ON",
                   "-D", f"VDRIVE_PYTHON={sys.executable}"]
    subprocess.run(command, check=True, stdout=sys.stderr)
    return pathlib.Path(chosen or ROOT / "build/release") / "python"


def _tag():
    version = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    return f"{version}-{version}-{platform}"


def _stripped(module, work):
    """Return the module without debug information, which is ten times as large as the code."""
    copy = pathlib.Path(work) / module.name
    shutil.copyfile(module, copy)
    subprocess.run(["strip", "--strip-unneeded", copy], check=True)
    return copy.read_bytes()


def _libraries(module):
    """Return the paths of the libraries that the wheel must contain."""
    text = subprocess.run(["ldd", module], check=True, capture_output=True, text=True).stdout
    found = [line.split()[::2][:2] for line in text.splitlines() if "=>" in line]
    return [pathlib.Path(path) for name, path in sorted(found) if not name.startswith(EVERYWHERE)]


def _license(library):
    """Return the package of a system library, and the text of its licence."""
    owner = subprocess.run(["dpkg-query", "--search", library.resolve()], check=True, capture_output=True,
                           text=True).stdout
    package = owner.split(":")[0]
    return package, pathlib.Path("/usr/share/doc", package, "copyright").read_bytes()


def _contents(package, work):
    """Return {path in the wheel: bytes} and {package of an included library: licence}."""
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    module = package / "vdrive" / f"_vdrive{suffix}"
    if not module.exists():
        raise RuntimeError(f"{module} is missing: the build has another Python than {sys.executable}")
    files = {f"vdrive/{file.name}": file.read_bytes()
             for file in sorted((package / "vdrive").iterdir())
             if file.suffix in (".py", ".pyi", ".typed") or file.name == "py.typed"}
    for library in (module, package / "vdrive" / "libvdrive_dds.so", *_libraries(module)):
        files[f"vdrive/{library.name}"] = _stripped(library, work)
    return files, dict(_license(library) for library in _libraries(module))


def _record(files, path):
    lines = []
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        lines.append(f"{name},sha256={digest},{len(content)}")
    return "\n".join(lines + [f"{path},,", ""]).encode()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Build the wheel; return its name."""
    package = _built_package()
    information = next(package.glob("vdrive-*.dist-info"))
    with tempfile.TemporaryDirectory() as work:
        files, licenses = _contents(package, work)
    for name in ("METADATA", "entry_points.txt"):
        files[f"{information.name}/{name}"] = (information / name).read_bytes()
    files[f"{information.name}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    for owner, text in licenses.items():
        files[f"{information.name}/licenses/{owner}"] = text
    files[f"{information.name}/WHEEL"] = (
        "Wheel-Version: 1.0\nGenerator: vdrive\nRoot-Is-Purelib: false\n"
        f"Tag: {_tag()}\n").encode()
    record = f"{information.name}/RECORD"
    files[record] = _record(files, record)
    name = f"{information.name.removesuffix('.dist-info')}-{_tag()}.whl"
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, content in files.items():
            entry = zipfile.ZipInfo(path)  # dated 1980, so that the same files give the same wheel
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if ".so" in path else 0o644) << 16
            wheel.writestr(entry, content)
    return name


def build_sdist(sdist_directory, config_settings=None):
    """Refuse: the module is built from the whole project."""
    raise NotImplementedError("build the wheel from the project's source tree")
