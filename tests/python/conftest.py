# SPDX-License-Identifier: Apache-2.0
"""--under-thread-sanitizer leaves out the tests that need DDS, whose library is not instrumented, and
those that cannot run under the sanitizer."""
pytest_plugins = ["pytester"]

OPTION = "--under-thread-sanitizer"


def pytest_addoption(parser):
    parser.addoption(OPTION, action="store_true", help="leave out what cannot run under it")


def needs_dds(item):
    """Whether a test needs DDS: by its parameter `over`, its marker `dds`, or its bench of the plug-in."""
    cases = item.callspec.params if hasattr(item, "callspec") else {}
    if "over" in cases:
        return cases["over"] == "dds"
    bench = item.get_closest_marker("vdrive")
    return item.get_closest_marker("dds") is not None or (
        bench is not None and bench.kwargs.get("over") == "dds")


def pytest_collection_modifyitems(config, items):
    if not config.getoption(OPTION):
        return
    left_out = [item for item in items if needs_dds(item) or item.get_closest_marker("not_watched")]
    config.hook.pytest_deselected(items=left_out)
    items[:] = [item for item in items if item not in left_out]
