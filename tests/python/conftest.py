# SPDX-License-Identifier: Apache-2.0
"""--without-dds leaves out the tests that need DDS, which the thread sanitizer does not know."""
pytest_plugins = ["pytester"]


def pytest_addoption(parser):
    parser.addoption("--without-dds", action="store_true", help="leave out the tests that need DDS")


def needs_dds(item):
    """By a case `over`, by the marker `dds`, or by a bench over DDS of the plug-in."""
    cases = item.callspec.params if hasattr(item, "callspec") else {}
    if "over" in cases:
        return cases["over"] == "dds"
    bench = item.get_closest_marker("vdrive")
    return item.get_closest_marker("dds") is not None or (
        bench is not None and bench.kwargs.get("over") == "dds")


def pytest_collection_modifyitems(config, items):
    if config.getoption("--without-dds"):
        config.hook.pytest_deselected(items=[item for item in items if needs_dds(item)])
        items[:] = [item for item in items if not needs_dds(item)]
