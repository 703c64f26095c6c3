# SPDX-License-Identifier: Apache-2.0
"""Options of vdrive.Bench, and benches that share a bus, in a process and over DDS."""
import pathlib

import pytest
import vdrive

OVER = pytest.mark.parametrize("over", ["local", "dds"])


# The limits are those of docs/guides/configuration.md; that of the domain is RTPS's, whose ports
# end at 65535.
@OVER
@pytest.mark.parametrize("options, message", [
    ({"axes": -1}, "axes = -1: must be from 1 to 16384"),
    ({"axes": 0}, "axes = 0: must be from 1 to 16384"),
    ({"axes": 16385}, "axes = 16385: must be from 1 to 16384"),
    ({"axes": 10**30}, f"axes = {10**30}: must be from 1 to 16384"),
    ({"axes": 2.5}, "axes = 2.5: must be a whole number from 1 to 16384"),
    ({"number": 0}, "number = 0: must be from 1 to 65535"),
    ({"number": 65536}, "number = 65536: must be from 1 to 65535"),
    ({"clock": "fast"}, "clock = 'fast': must be one of lockstep, realtime, freerun"),
    ({"clock": None}, "clock = None: must be one of"),
    ({"config": "nowhere.yaml"}, "config = 'nowhere.yaml': No such file or directory"),
    ({"config": "/"}, "config = '/': Is a directory"),
    ({"config": ""}, "config = '': must be a path"),
    ({"state": ""}, "state = '': must be a path"),
    # The names are those of deploy/axes.
    ({"preset": "ball-skrew"}, "preset = 'ball-skrew': must be one of ball-screw, conveyor, .*, winder$"),
    ({"preset": ""}, "preset = '': must be one of ball-screw, "),
])
def test_a_value_that_no_bench_can_have_is_named_with_its_limit(over, options, message):
    with pytest.raises(vdrive.ConfigurationError, match=message):
        vdrive.Bench(over=over, **options)


@OVER
@pytest.mark.parametrize("options, message", [
    ({"axes": "2"}, "axes = '2': must be a whole number from 1 to 16384"),
    ({"axes": True}, "axes = True: must be a whole number"),
    ({"number": [1]}, r"number = \[1\]: must be a whole number from 1 to 65535"),
    ({"config": 7}, "config = 7: must be a path"),
    ({"journal": 1.5}, "journal = 1.5: must be a path"),
    ({"preset": 7}, "preset = 7: must be the name of a machine"),
    ({"beside": 2}, "beside = 2: must be a vdrive.Bench"),
])
def test_a_value_of_a_wrong_type_is_named(over, options, message):
    with pytest.raises(TypeError, match=message):
        vdrive.Bench(over=over, **options)


@pytest.mark.dds
def test_the_form_of_a_bench_and_its_domain_are_checked():
    with pytest.raises(ValueError, match="over = 'serial': must be one of local, dds"):
        vdrive.Bench(over="serial")
    with pytest.raises(vdrive.ConfigurationError, match="domain = 233: must be from 0 to 232"):
        vdrive.Bench(over="dds", domain=233)
    with pytest.raises(TypeError, match="domain = 'a': must be a whole number from 0 to 232"):
        vdrive.Bench(over="dds", domain="a")
    with pytest.raises(TypeError, match="arguments = '--period 500': must be a list of words"):
        vdrive.Bench(over="dds", arguments="--period 500")


def test_whole_numbers_of_numpy_are_taken():
    import numpy
    with vdrive.Bench(axes=numpy.float64(3), number=numpy.uint8(9)) as bench, bench.session() as session:
        assert [axis.id for axis in session.find_bench().axes] == ["9.1", "9.2", "9.3"]


@pytest.mark.dds
def test_benches_of_two_forms_cannot_be_combined():
    with vdrive.Bench(axes=1) as local:
        with pytest.raises(vdrive.ConfigurationError, match="in this process.*over DDS"):
            vdrive.Bench(over="dds", number=2, beside=local)
    with vdrive.Bench(axes=1, over="dds") as remote:
        with pytest.raises(vdrive.ConfigurationError, match="over DDS.*in this process"):
            vdrive.Bench(number=2, beside=remote)
        with pytest.raises(vdrive.ConfigurationError, match="beside= and domain="):
            vdrive.Bench(over="dds", number=2, beside=remote, domain=remote.domain)


@pytest.mark.dds
def test_a_bench_over_dds_joins_the_domain_of_another():
    with vdrive.Bench(axes=1, over="dds") as first, \
            vdrive.Bench(axes=1, over="dds", number=2, domain=first.domain) as second:
        assert second.domain == first.domain
        with second.session() as session:
            assert session.axis("1.1").id == "1.1" and session.axis("2.1").id == "2.1"
    with pytest.raises(vdrive.Failed, match="ended"):
        vdrive.Bench(axes=1, over="dds", number=2, beside=first)


def test_benches_of_the_fixture_meet_and_step_together(vdrive_benches):
    first, second = vdrive_benches(2, axes=1)
    with first.session() as session, vdrive.StepClock(session, [1, 2]) as clock:
        # Each bench starts at tick 0, and runs 10 ticks in a step of 10.
        before = [session.find_bench(number).tick for number in (1, 2)]
        assert clock.step(10) == [tick + 10 for tick in before]
    with second.session() as session:
        group = vdrive.AxisGroup(session, ["1.1", "2.1"])
        group.enable_all()
        group.move_together([4000.0, -2000.0])
        assert group.status().demand.tolist() == [4000.0, -2000.0]


@pytest.mark.vdrive(axes=3)
def test_benches_of_the_fixture_have_the_options_of_the_marker_and_of_the_call(vdrive_benches):
    one, = vdrive_benches(1)
    pair = vdrive_benches(2, axes=2)
    with one.session() as session:
        assert len(session.find_bench(1).axes) == 3
        with pytest.raises(vdrive.NotFound):  # benches of separate calls do not share a bus
            session.axis("2.1")
    with pair[1].session() as session:
        assert session.axis("2.2").id == "2.2"


@OVER
def test_axes_replace_those_of_a_configuration(over, tmp_path):
    config = tmp_path / "one.yaml"
    config.write_text("axes: [{number: 7, name: alone}]\n")
    with vdrive.Bench(3, config=config, over=over) as bench, bench.session() as session:
        assert [axis.id for axis in session.axes()] == ["1.1", "1.2", "1.3"]


# A ball screw has 4096 UU per turn, 409.6 for each mm of its 10 mm pitch. The encoder of the winder
# is on its motor: 20 turns of 4096 UU before a gear of 20:1 are one turn of the reel.
@OVER
@pytest.mark.parametrize("options, axes, unit", [
    ({"axes": 3, "preset": "ball-screw"}, ["1.1", "1.2", "1.3"], ("mm", 409.6)),
    ({"preset": "winder"}, ["1.1"], ("rev", 81920)),
])
def test_a_preset_says_of_which_machine_the_axes_are(over, options, axes, unit):
    with vdrive.Bench(over=over, **options) as bench, bench.session() as session:
        found = session.axes()
        assert [axis.id for axis in found] == axes
        assert {(axis.unit.name, axis.unit.size) for axis in found} == {unit}


def test_a_preset_replaces_the_axes_of_a_configuration(tmp_path):
    config = tmp_path / "one.yaml"
    config.write_text("bench: {number: 4}\naxes: [{number: 7, name: alone}]\n")
    with vdrive.Bench(preset="vertical", config=config) as bench, bench.session() as session:
        assert [axis.id for axis in session.axes()] == ["4.1"]


def test_the_presets_are_the_files_of_deploy():
    files = (pathlib.Path(__file__).resolve().parents[2] / "deploy/axes").glob("*.yaml")
    assert list(vdrive.PRESETS) == sorted(file.stem for file in files)


@pytest.mark.vdrive(axes=2, preset="linear-motor")
def test_the_marker_chooses_the_machine(vdrive_session):
    # 24 mm per turn of the load: 4096 / 24 UU per millimetre.
    assert [axis.unit.name for axis in vdrive_session.axes()] == ["mm", "mm"]
    assert vdrive_session.axis("1.2").unit.size == pytest.approx(4096 / 24)


def test_no_bench_at_all_is_refused(vdrive_benches):
    with pytest.raises(vdrive.ConfigurationError, match="count = 0: must be from 1 to 65535"):
        vdrive_benches(0)
    with pytest.raises(TypeError, match="count = '2'"):
        vdrive_benches("2")


def test_the_numbers_of_several_benches_are_not_chosen(vdrive_benches):
    with pytest.raises(vdrive.ConfigurationError, match="number = 3: vdrive_benches chooses it"):
        vdrive_benches(2, number=3)


@pytest.mark.vdrive(3)
def test_the_marker_takes_the_number_of_axes_without_its_name(vdrive_session):
    assert len(vdrive_session.axes()) == 3


@pytest.mark.parametrize("path, reason", [("a\0b", "a\\\\x00b"), (b"\xff", "UTF-8")])
def test_a_path_that_cannot_be_one_is_refused_by_its_name(path, reason):
    with pytest.raises(vdrive.ConfigurationError, match=f"state = .*{reason}"):
        vdrive.Bench(1, state=path)
