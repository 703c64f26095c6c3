# SPDX-License-Identifier: Apache-2.0
# The C++ module is private, and takes and gives plain values. What its values are is written once, in
# the classes of the package that call it.
from typing import Any

def __getattr__(name: str) -> Any: ...
