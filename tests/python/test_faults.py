# SPDX-License-Identifier: Apache-2.0
"""The data that a bench keeps around a fault, in Python."""
import pytest
import vdrive


def fault(session):
    """Cause a fault of axis 1.1 on a bench in lock-step, then let a second pass."""
    axis = session.axis("1.1")
    axis.write(0x5E03, 1)  # over-temperature: a test-bench input
    session.step(1000)
    return axis


@pytest.mark.vdrive(axes=2)
def test_a_fault_is_shown_tick_by_tick_with_who_wrote_what(vdrive_bench, vdrive_session):
    vdrive_session.step(3000)
    fault(vdrive_session)
    kept, = vdrive_session.faults()
    assert kept == vdrive_bench.faults()[0]
    cause, = kept.causes
    assert (cause.kind, cause.axis, cause.code, cause.tick) == ("fault", 1, 0x4310, 3001)
    window = vdrive_session.fault(kept.number)
    # From 2 s before to 0.5 s after the fault, in ticks of 1 ms.
    assert list(window.recording.ticks) == list(range(1001, 3502))
    assert window.recording.axes == ["1.1"]
    assert list(window.recording["error_code"][:, 0]) == [0] * 2000 + [0x4310] * 501
    write, = window.writes
    assert write == vdrive.Write(3000, 1, (0x5E03, 0), 1, vdrive_session.id, 0)
    assert "test_over_temperature" in str(window.stories[0])
    assert any(event.kind == "fault" and event.axis == 1 for event in window.events)


@pytest.mark.vdrive(axes=3)
def test_other_axes_are_shown_too(vdrive_session):
    fault(vdrive_session)
    number = vdrive_session.faults()[0].number
    assert vdrive_session.fault(number, ["1.3", "1.2"]).recording.axes == ["1.3", "1.2"]
    assert len(vdrive_session.fault(number, vdrive_session.axes()).recording.axes) == 3


def test_now_can_be_kept_without_a_fault(vdrive_session):
    vdrive_session.step(10)
    number = vdrive_session.freeze()
    window = vdrive_session.fault(number)
    assert window.fault.causes[0].kind == "asked for"
    assert window.recording.ticks[-1] == 10


def test_a_fault_that_is_not_kept_is_not_found(vdrive_session):
    with pytest.raises(vdrive.NotFound, match="no fault 5"):
        vdrive_session.fault(5)
