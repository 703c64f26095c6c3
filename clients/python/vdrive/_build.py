# SPDX-License-Identifier: Apache-2.0
"""Checks that this package was built for the running Python."""
from __future__ import annotations

import importlib.machinery
import pathlib
import re
import sys


def check() -> None:
    """Raise ImportError when the package has no module for this Python."""
    package = pathlib.Path(__file__).parent
    built = sorted(file.name for file in package.glob("_vdrive.*.so"))
    if any(name == "_vdrive" + suffix for name in built
           for suffix in importlib.machinery.EXTENSION_SUFFIXES):
        return
    versions = [re.sub(r"_vdrive\.cpython-(\d)(\d+)-.*", r"Python \1.\2", name) for name in built]
    raise ImportError(
        f"{package} is built for {', '.join(versions) or 'no Python at all'}, but this is Python "
        f"{sys.version_info.major}.{sys.version_info.minor} ({sys.executable}). In the source tree of "
        f"vdrive, `deploy/build.sh --target vdrive_python -D VDRIVE_BUILD_PYTHON=ON "
        f"-D VDRIVE_PYTHON={sys.executable}` builds it for this one") from None
