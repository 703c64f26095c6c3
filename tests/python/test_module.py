# SPDX-License-Identifier: Apache-2.0
"""The module as readers see it: signatures, docstrings, recordings of the tool."""
import ast
import enum
import inspect
import os
import pathlib
import pickle
import re
import shutil
import subprocess
import sys

import numpy
import pytest
import vdrive

CLASSES = {name: value for name, value in vars(vdrive).items()
           if inspect.isclass(value) and not issubclass(value, Exception) and name in vdrive.__all__}


def own_members(kind):
    return {name: value for name, value in vars(kind).items()
            if not name.startswith("_") or name in ("__init__", "__iter__", "__next__", "__len__",
                                                    "__getitem__", "__enter__", "__exit__", "__await__")}


@pytest.mark.parametrize("call, signature", [
    (vdrive.Motion.wait, "(self, timeout: 'float' = 60.0) -> 'None'"),
    (vdrive.Axis.enable, "(self, *, timeout: 'float' = 60.0, until: 'UntilSpec' = 'done', "
                         "keep_target: 'bool' = False) -> 'None'"),
    (vdrive.Session.step, "(self, ticks: 'NumberSpec' = 1, *, bench: 'int | None' = None) -> 'int'"),
    (vdrive.AxisGroup.stream, "(self, set_points: 'ArrayLike') -> 'GroupStatus'"),
    (vdrive.default_domain, "() -> 'int'"),
])
def test_a_call_has_a_signature_with_its_types_and_defaults(call, signature):
    assert str(inspect.signature(call)) == signature


def test_a_session_of_a_bench_has_the_parameters_of_a_session():
    expected, parameters = (
        {each.name: (each.annotation, each.default) for each in inspect.signature(call).parameters.values()
         if each.kind is each.KEYWORD_ONLY} for call in (vdrive.Session, vdrive.Bench.session))
    for known_by_the_bench in ("domain", "local", "service"):
        del expected[known_by_the_bench]
    assert parameters == expected


@pytest.mark.parametrize("name", CLASSES)
def test_an_object_without_content_is_refused(name):
    if issubclass(CLASSES[name], tuple):
        with pytest.raises(TypeError):
            CLASSES[name].__new__(CLASSES[name])
        return
    empty = CLASSES[name].__new__(CLASSES[name])
    for member, value in vars(CLASSES[name]).items():
        if isinstance(value, property):
            with pytest.raises((AttributeError, TypeError)):
                value.fget(empty)


def test_an_empty_status_is_refused_by_its_methods(vdrive_session):
    empty = vdrive.Status.__new__(vdrive.Status)
    for call in (lambda: empty.value(0x6041), lambda: repr(empty), lambda: hash(empty),
                 lambda: pickle.dumps(empty), lambda: empty == vdrive_session.axis("1.1").status()):
        with pytest.raises(AttributeError):
            call()


@pytest.mark.parametrize("name", ["Status", "Unit", "Event", "BenchInfo", "Observation", "Axis", "Session"])
def test_what_a_program_reads_it_cannot_change(vdrive_session, name):
    axis = vdrive_session.axis("1.1")
    axis.enable()
    each = {"Status": axis.status, "Unit": lambda: axis.unit, "BenchInfo": vdrive_session.find_bench,
            "Event": lambda: vdrive_session.events(history=True).next(), "Axis": lambda: axis,
            "Observation": vdrive_session.observe, "Session": lambda: vdrive_session}[name]()
    public = [member for member in dir(each) if not member.startswith("_")
              and not callable(getattr(each, member))]
    for member in public:
        with pytest.raises(AttributeError):
            setattr(each, member, 1)


def test_every_public_name_has_a_docstring():
    missing = []
    for name in vdrive.__all__:
        value = getattr(vdrive, name)
        if inspect.isclass(value) or callable(value):
            text = value.__doc__ or ""
            missing += [name] if not text.strip() else []
        if not inspect.isclass(value):
            continue
        for member, item in own_members(value).items():
            if member.startswith("_"):
                continue
            text = inspect.getdoc(item) or ""
            missing += [f"{name}.{member}"] if not text else []
    assert missing == []


def test_the_members_of_a_status_are_those_of_a_record(vdrive_session):
    status = vdrive_session.axis("1.1").status()
    record = vdrive_session.observe("1.1").array()[0]
    for name in record.dtype.names:
        if name not in ("missed",):
            assert getattr(status, name) == record[name], name


@pytest.mark.vdrive(over="dds")  # which the tool can find
def test_a_recording_of_the_tool_is_read_back_unchanged(vdrive_bench, vdrive_session, tmp_path):
    axis = vdrive_session.axis("1.1")
    axis.enable()
    path = tmp_path / "run.csv"
    tool = subprocess.Popen(
        [os.environ["VDRIVE_TOOL"], "--domain", str(vdrive_bench.domain), "--timeout", "30", "record",
         str(path), "1.1", "1.2", "--count", "40"], stderr=subprocess.PIPE)
    motion = axis.start_move(300)
    while tool.poll() is None:
        vdrive_session.step()
    assert tool.returncode == 0, tool.stderr.read()
    recording = vdrive.load(path)
    assert recording.axes == ["1.1", "1.2"] and recording["position"].shape == (40, 2)
    assert recording.axis("1.1")["owner"].tolist() == [vdrive_session.id] * 40
    lines = path.read_text().splitlines()
    column = lines[0].split(",").index("load_position_actual_value")
    written = [int(line.split(",")[column]) for line in lines[1:] if line.startswith("1.1,")]
    assert recording["position"][:, 0].tolist() == written
    motion.wait()


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """A recording of a move of two axes by the tool, as CSV and as MCAP; the tool uses a service.
    """
    directory = tmp_path_factory.mktemp("recordings")
    with vdrive.Bench(over="dds") as bench, bench.session() as session:
        axis = session.axis("1.1")
        axis.enable()
        for ending in ("csv", "mcap"):
            tool = subprocess.Popen(
                [os.environ["VDRIVE_TOOL"], "--domain", str(bench.domain), "--timeout", "30", "record",
                 str(directory / f"run.{ending}"), "--count", "40"], stderr=subprocess.PIPE)
            motion = axis.start_move(300 if ending == "csv" else 600)
            while tool.poll() is None:
                session.step()
            assert tool.returncode == 0, tool.stderr.read()
            motion.wait()
    return directory


@pytest.mark.dds
def test_a_recording_has_the_same_arrays_in_each_format(recordings, tmp_path):
    mcap = shutil.copy(recordings / "run.mcap", tmp_path)
    for ending in ("csv", "jsonl"):
        subprocess.run([os.environ["VDRIVE_TOOL"], "convert", mcap, tmp_path / f"run.{ending}"],
                       check=True, stderr=subprocess.DEVNULL)
    recordings = [vdrive.load(tmp_path / f"run.{ending}") for ending in ("csv", "jsonl", "mcap")]
    for recording in recordings:
        assert recording.axes == ["1.1", "1.2"] and recording.names == ["x", "y"]
        assert recording.cut == "" and len(recording) == 40
        assert recording["position"].max() > 0
    # The fields that a text recording has: all except the owner's epoch.
    for field in recordings[0].frames.dtype.names:
        if field == "owner_epoch":
            continue
        for other in recordings[1:]:
            assert numpy.array_equal(recordings[0][field], other[field]), field


@pytest.mark.dds
def test_a_recording_has_drive_times_where_its_format_says_how_long_a_tick_is(recordings, tmp_path):
    mcap = shutil.copy(recordings / "run.mcap", tmp_path)
    subprocess.run([os.environ["VDRIVE_TOOL"], "convert", mcap, tmp_path / "run.csv"],
                   check=True, stderr=subprocess.DEVNULL)
    whole = vdrive.load(mcap)
    # A tick is 1 ms.
    assert whole.period == 0.001
    assert numpy.allclose(whole.time, (whole.ticks - whole.ticks[0]) * 0.001) and whole.time[0] == 0.0
    text = vdrive.load(tmp_path / "run.csv")
    with pytest.raises(ValueError, match=r"the period of a tick: load\(\.\.\., period=0.001\)"):
        text.time
    assert numpy.array_equal(vdrive.load(tmp_path / "run.csv", period=0.001).time, whole.time)


@pytest.mark.dds
def test_an_incomplete_recording_is_read_up_to_its_end(recordings, tmp_path):
    whole = recordings / "run.mcap"
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[:-100])
    recording = vdrive.load(cut)
    assert recording.cut != "" and len(recording) <= 40


@pytest.mark.parametrize("name, content", [
    ("bad.mcap", b"no recording"), ("bad.jsonl", b"{}\n"), ("bad.txt", b"")])
def test_a_file_that_the_library_cannot_read_is_an_error_that_names_it(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ValueError, match=name):
        vdrive.load(path)


ENUMS = ["ErrorCode", "OperatingMode", "PowerState", "Reason", "Statusword"]


@pytest.mark.parametrize("name, members, member, value", [
    ("PowerState", 8, "FAULT", 7), ("OperatingMode", 10, "CYCLIC_SYNCHRONOUS_TORQUE", 10),
    ("Statusword", 18, "HOMING_ATTAINED", 0x1000), ("ErrorCode", 10, "FOLLOWING_ERROR", 0x8611),
    ("Reason", 55, "NO_DATA_AVAILABLE", 0x08000024)])
def test_an_enumeration_has_the_rows_of_its_table(name, members, member, value):
    kind = getattr(vdrive, name)
    assert issubclass(kind, enum.IntFlag if name == "Statusword" else enum.IntEnum)
    assert kind.__module__ == "vdrive" and kind[member] == value
    # Including the alternative names of bits whose meaning depends on the mode.
    assert len(kind.__members__) >= members


def test_enumerations_are_what_the_calls_give(vdrive_session):
    axis = vdrive_session.axis("1.1")
    axis.enable()
    axis.move_to(10)
    status = axis.status()
    assert status.power_state is vdrive.PowerState.OPERATION_ENABLED
    assert status.op_mode_actual == vdrive.OperatingMode.PROFILE_POSITION
    assert status.shows(vdrive.Statusword.TARGET_REACHED | vdrive.Statusword.OPERATION_ENABLED)
    assert vdrive.Statusword.TARGET_REACHED in vdrive.Statusword(status.statusword)
    with pytest.raises(vdrive.Refused) as refusal:
        axis.write(0x6041, 1)
    assert refusal.value.code == vdrive.Reason.WRITE_OF_READ_ONLY_OBJECT
    axis.disturb("over_current")
    broken = axis.wait_until(lambda seen: seen.power_state == vdrive.PowerState.FAULT)
    assert broken.error_code == vdrive.ErrorCode.CONTINUOUS_OVER_CURRENT
    assert pickle.loads(pickle.dumps(vdrive.Reason.NOT_OWNER)) is vdrive.Reason.NOT_OWNER
    assert set(ENUMS) <= set(dir(vdrive)) & set(vdrive.__all__)
    with pytest.raises(AttributeError, match="no attribute 'PowerStates'"):
        vdrive.PowerStates


def test_importing_the_module_reads_no_enumerations():
    program = "import sys, vdrive; print('vdrive._enums' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True).stdout == "False\n"


def recorded(session):
    session.axis("1.1").enable()
    session.axis("1.1").start_move(4000, velocity=20000)
    return session.record(["1.1", "1.2"], ticks=30)


@pytest.mark.parametrize("ending", ["csv", "jsonl", "json", "mcap"])
def test_a_recording_that_was_saved_is_loaded_as_it_was(vdrive_session, tmp_path, ending):
    saved = recorded(vdrive_session)
    path = tmp_path / f"run.{ending}"
    path.write_text("an older file")
    saved.save(path)
    assert list(tmp_path.iterdir()) == [path]
    loaded = vdrive.load(path, period=0.001)
    assert numpy.array_equal(loaded.frames, saved.frames) and loaded["position"].max() > 0
    assert (loaded.axes, loaded.names, loaded.period) == (saved.axes, saved.names, 0.001)
    # The tool accepts it, too, and a part of a recording is again a recording.
    saved.frames = saved.frames[10:20]
    saved.save(str(path))
    assert vdrive.load(path).ticks.tolist() == saved.ticks.tolist()
    other = tmp_path / ("other.csv" if ending == "mcap" else "other.mcap")
    subprocess.run([os.environ["VDRIVE_TOOL"], "convert", path, other], check=True)
    assert numpy.array_equal(vdrive.load(other).frames, saved.frames)


def broken(recording, **members):
    for name, value in members.items():
        setattr(recording, name, value)
    return recording


def retyped(recording, **changes):
    """Give the records of a recording a type without short names, and with a changed description.
    """
    own = recording.frames.dtype
    formats, offsets = zip(*(own.fields[name][:2] for name in own.names))
    description = {"names": own.names, "formats": formats, "offsets": offsets}
    for key, change in changes.items():
        description[key] = change(list(description[key]))
    return broken(recording, frames=recording.frames.view(numpy.dtype(description)))


def test_records_without_short_names_as_of_an_earlier_version_are_saved(vdrive_session, tmp_path):
    recording = retyped(recorded(vdrive_session))
    assert "position" not in recording.frames.dtype.fields
    recording.save(tmp_path / "run.csv")
    assert vdrive.load(tmp_path / "run.csv").frames.tolist() == recording.frames.tolist()


@pytest.mark.parametrize("name, change, reason", [
    ("run.txt", lambda r: r, ".csv, .jsonl or .mcap"),
    ("run", lambda r: r, ".csv, .jsonl or .mcap"),
    ("run.mcap", lambda r: broken(r, period=None), "needs the period of a tick"),
    ("run.csv", lambda r: broken(r, frames=r.frames[:0]), "the recording has no sample"),
    ("run.csv", lambda r: broken(r, frames=r.frames[::-1]), "tick .* follows the tick"),
    ("run.csv", lambda r: broken(r, frames=r.frames[:, :1]), "a column for each of its 2 axes"),
    ("run.csv", lambda r: broken(r, frames=r["position"]), "the dtype of vdrive.record_type"),
    ("run.csv", lambda r: retyped(r, names=lambda names: names[::-1]), "the dtype of vdrive.record_type"),
    ("run.csv", lambda r: retyped(r, formats=lambda old: [">u8", *old[1:]]), "the dtype of vdrive.record_type"),
    ("run.csv", lambda r: retyped(r, offsets=lambda old: [*old[1::-1], *old[2:]]), "the dtype of vdrive.record_type"),
    ("run.csv", lambda r: broken(r, axes=["1.1", "2.1"]), "1.1 and 2.1 are on different benches"),
    ("run.csv", lambda r: broken(r, axes=["1.1", "lift"]), "axis 'lift' is not an address such as 1.2"),
    ("run.csv", lambda r: broken(r, names=["x"]), "2 axes and 1 names"),
])
def test_what_a_file_cannot_have_is_refused_and_an_older_file_stays(vdrive_session, tmp_path, name, change, reason):
    recording = change(recorded(vdrive_session))
    path = tmp_path / name
    path.write_text("an older file")
    with pytest.raises(ValueError, match=f"cannot save '.*{name}': .*{reason}"):
        recording.save(path)
    assert path.read_text() == "an older file" and list(tmp_path.iterdir()) == [path]


def test_a_file_that_cannot_be_written_is_an_error_of_the_system(vdrive_session, tmp_path):
    recording = recorded(vdrive_session)
    with pytest.raises(OSError, match="cannot write '.*/none/run.csv': No such file or directory"):
        recording.save(tmp_path / "none" / "run.csv")
    (tmp_path / "run.csv").mkdir()
    with pytest.raises(OSError, match="run.csv': it is not a regular file"):
        recording.save(tmp_path / "run.csv")
    # A link stays a link: its target is written.
    (tmp_path / "link.csv").symlink_to("behind.csv")
    recording.save(tmp_path / "link.csv")
    assert (tmp_path / "link.csv").is_symlink() and len(vdrive.load(tmp_path / "behind.csv")) == 30


def words_of_type(module, name):
    """Return the texts of `name = Literal[...]` in a module of the package, which only type
    checkers read."""
    package = pathlib.Path(vdrive.__file__).parent
    for node in ast.walk(ast.parse((package / f"{module}.py").read_text())):
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == name:
            elements = node.value.slice
            return [each.value for each in getattr(elements, "elts", [elements])]
    raise AssertionError(name)


def test_the_words_of_a_type_are_those_that_the_calls_take(vdrive_session):
    assert tuple(words_of_type("_enums", "DisturbanceSpec")) == vdrive.DISTURBANCES
    axis = vdrive_session.axis("1.1")
    for command in words_of_type("_axis", "CommandSpec"):
        assert len(vdrive_session.command_each(axis, command)) == 1 and callable(getattr(axis, command))
    for until in words_of_type("_arguments", "UntilSpec"):
        axis.disable(until=until)
    for pace in words_of_type("_arguments", "PaceSpec"):
        vdrive_session.follow("1.1", pace=pace).close()


def test_the_help_of_disturb_explains_each_disturbance():
    for name in vdrive.DISTURBANCES:
        assert f"        {name}\n" in vdrive.Axis.disturb.__doc__


@pytest.mark.parametrize("text, complaint", [
    ("", "the file is empty"), ("a,b\n", "line 1: there is no column 'a'"),
    ("axis,name,tick,missed\n1.1,x,1,0\n", "line 1: it lacks the column")])
def test_a_file_that_is_not_a_recording_is_an_error_that_names_the_place(tmp_path, text, complaint):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=complaint):
        vdrive.load(path)


@pytest.mark.dds
def test_one_bench_of_a_recording_of_several_can_be_chosen(recordings, tmp_path):
    one = (recordings / "run.csv").read_text().splitlines(True)
    two = [line.replace("1.", "2.", 1) for line in one[1:] if line.startswith("1.1,")]
    path = tmp_path / "two.csv"
    path.write_text("".join(one + two))
    with pytest.raises(ValueError, match="several benches"):
        vdrive.load(path)
    recording = vdrive.load(path, bench=2)
    assert recording.axes == ["2.1"] and recording.names == ["x"] and len(recording) == 40
    assert vdrive.load(path, bench=1).axes == ["1.1", "1.2"]
    with pytest.raises(ValueError, match="two.csv: bench = 9 is not in it, it has 1, 2"):
        vdrive.load(path, bench=9)


def test_a_recording_without_samples_has_no_times(vdrive_session, tmp_path):
    path = tmp_path / "run.csv"
    recorded(vdrive_session).save(path)
    path.write_text(path.read_text().splitlines(True)[0])
    recording = vdrive.load(path, period=0.001)
    assert (recording.ticks.size, recording.time.size, recording.missed, len(recording)) == (0, 0, 0, 0)
    for period in (0, -1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="period = .*: must be a"):
            vdrive.load(path, period=period)


def answers_about(path):
    """Return the errors of vdrive.load and `vdrive convert` for a recording."""
    with pytest.raises(ValueError) as refusal:
        vdrive.load(path)
    tool = subprocess.run([os.environ["VDRIVE_TOOL"], "convert", path, path.with_suffix(".jsonl")],
                          stderr=subprocess.PIPE, text=True)
    assert tool.returncode != 0
    return str(refusal.value), tool.stderr.removeprefix("vdrive: ").rstrip("\n")


@pytest.mark.dds
def test_a_text_that_is_cut_anywhere_has_one_answer_of_the_tool_and_the_module(recordings, tmp_path):
    whole = (recordings / "run.csv").read_bytes()
    cut = tmp_path / "cut.csv"
    last = whole.rindex(b"\n", 0, -1) + 1
    for size, reason in ((last, "1 of 2 axes"), (len(whole) - 1, "no line break"),
                         (last + 20, "no line break")):
        cut.write_bytes(whole[:size])
        module, tool = answers_about(cut)
        assert module == tool and reason in module


def test_objects_show_no_address(vdrive_bench, vdrive_session):
    axis = vdrive_session.axis("1.1")
    axis.enable()
    for each in (vdrive_bench, axis.start_move(10), vdrive_session.follow(), vdrive_session.stream(),
                 vdrive_session.events(), vdrive_session.service_changes(), vdrive.AxisBank(1),
                 vdrive_session.on_status(print, "1.1")):
        assert re.fullmatch(r"<vdrive\.[A-Z]\w+[^@]*>", repr(each)) and " at 0x" not in repr(each)


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_a_pickle_works_or_is_refused(vdrive_bench, vdrive_session, protocol):
    axis = vdrive_session.axis("1.1")
    for each in (axis.status(), axis.unit, vdrive_session.find_bench().axes[0]):
        assert pickle.loads(pickle.dumps(each, protocol)) == each
    for each in (axis, vdrive_session, vdrive_session.observe(), vdrive_session.find_bench(), vdrive_bench):
        with pytest.raises(TypeError, match="pickle"):
            pickle.dumps(each, protocol)


def test_what_a_program_names_has_the_name_by_which_it_is_imported():
    classes = [each for each in map(vars(vdrive).get, vdrive.__all__) if inspect.isclass(each)]
    assert vdrive.Failed in classes and vdrive.Bench in classes and vdrive.Motion in classes
    for each in classes:
        assert each.__module__ == "vdrive", each
        assert pickle.loads(pickle.dumps(each)) is each


def test_short_names_are_those_of_a_status_in_every_array_of_records():
    with vdrive.Bench(2) as bench, bench.session() as session:
        session.axis("1.2").enable()
        session.axis("1.2").move_to(700)
        observed = session.observe()
        recording = session.record(ticks=2)
        short = [name for name in vdrive.record_type().fields if name not in vdrive.record_type().names]
        assert {"position", "demand", "velocity", "torque", "statusword", "following_error"} == set(short)
        for name in short:
            assert observed.array()[name][1] == getattr(observed[1], name)
            assert (recording.axis("1.2")[name] == recording[name][:, 1]).all()
            assert (recording.frames[name] == recording[name]).all()


@pytest.mark.parametrize("ending", ["csv", "jsonl", "mcap", "txt"])
def test_a_recording_that_cannot_be_opened_is_an_error_of_the_system(tmp_path, ending):
    with pytest.raises(FileNotFoundError, match="missing"):
        vdrive.load(tmp_path / f"missing.{ending}")
    with pytest.raises(ValueError):
        vdrive.load(tmp_path)  # opened, but not a file
