# SPDX-License-Identifier: Apache-2.0
# The C++ module is private and uses plain values. They are documented once, in the classes of the
# package that call it.
from typing import Any

def __getattr__(name: str) -> Any: ...
