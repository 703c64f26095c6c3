// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/interpolated_position.hpp"

#include "drive/interpolation.hpp"
#include "drive/stops.hpp"
#include "drive/window.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace vdrive {
namespace {

using namespace vdrive::literals;

static_assert(kObjectRows["interpolation_buffer_maximum_size"_object].default_value ==
                      static_cast<std::int64_t>(kRecordBufferSize) &&
                  kObjectRows["interpolation_buffer_size"_object].upper_limit ==
                      static_cast<std::int64_t>(kRecordBufferSize),
              "60C4h shows the buffer that the drive has");

/// Bit 4 requests interpolation and no stop command takes precedence.
bool interpolates(const Drive& drive) {
  return obeys_mode(drive) && !halted(drive) &&
         (drive.state().controlword & Controlword::kEnableInterpolation) != 0;
}

/// With 60C4h:02 = 1 records do not queue: each one starts its interpolation immediately, as in
/// mode 8.
bool has_buffer(const Drive& drive) {
  return reg(drive, "interpolation_buffer_size"_object) > 1;
}

/// Limited, because a snapshot read from a file may hold any count.
std::size_t waiting_records(const Drive& drive) {
  return std::min<std::size_t>(drive.registers().record_buffer.count, kRecordBufferSize);
}

/// @return whether a record may be added: 60C4h:06 has enabled the buffer and it is not full.
bool has_room(const Drive& drive) {
  const std::size_t size = std::min<std::size_t>(
      unsigned_reg(drive, "interpolation_buffer_size"_object), kRecordBufferSize);
  return reg(drive, "interpolation_buffer_clear"_object) != 0 && waiting_records(drive) < size;
}

/// Records are accepted in Operation enabled, even while bit 4 is 0. Without a buffer, the next
/// record replaces one that no tick has taken yet.
void take_record(Drive& drive, ObjectRow row) {
  if (row != "interpolation_data_record"_object || !operation_enabled(drive)) return;
  const bool buffers = has_buffer(drive);
  if (buffers && !has_room(drive)) {
    ++drive.state().ignored_set_points;
    return;
  }
  RecordBuffer& buffer = drive.registers().record_buffer;
  const std::size_t count = buffers ? waiting_records(drive) : 0;
  const std::size_t place = (buffer.first + count) % kRecordBufferSize;
  buffer.records[place] = static_cast<std::int32_t>(reg(drive, "interpolation_data_record"_object));
  buffer.count = static_cast<std::uint8_t>(count + 1U);
}

/// The first record of the buffer starts when the previous one has ended. Without a buffer it
/// starts immediately, and a repetition of the same record is ignored.
void pull_record(Drive& drive) {
  StreamState& stream = drive.state().modes.stream;
  RecordBuffer& buffer = drive.registers().record_buffer;
  Interpolation& way = drive.registers().interpolation;
  const bool buffers = has_buffer(drive);
  const std::size_t count = waiting_records(drive);
  if (count == 0 || (buffers && is_streaming(drive) && way.ticks_left != 0)) return;
  const std::size_t first = buffer.first % kRecordBufferSize;
  const std::int32_t record = buffer.records[first];
  buffer.first = static_cast<std::uint8_t>((first + 1U) % kRecordBufferSize);
  buffer.count = static_cast<std::uint8_t>(count - 1U);
  stream.written = true;
  if (!buffers && is_streaming(drive) && record == way.set_point) return;
  way.set_point = record;
  stream.stage = StreamStage::begins;
}

/// @return the record that the demand is heading for.
std::int32_t present_record(const Drive& drive) {
  return drive.registers().interpolation.set_point;
}

/// Bit 4 is a level that each tick reads, so its edges are not counted.
void command(Drive& /*drive*/, const WrittenControlword& /*word*/) {}

/// A record moves the axis only once: when interpolation ends, the rest of the interrupted move is
/// dropped, while records that no tick has taken yet stay in the buffer.
void advance(Drive& drive) {
  DriveState& s = drive.state();
  if (!interpolates(drive)) {
    end_stream(drive);
    return;
  }
  pull_record(drive);
  if (!is_streaming(drive)) return;
  s.target.given_up = false;
  if (!take_set_point(drive, present_record(drive))) return;
  const double target = streamed_position(drive, present_record(drive));
  if (give_up_target_at_limit_switch(drive, target - demand_position(drive))) {
    end_stream(drive);
    drive.registers().record_buffer.count = 0;
  }
}

/// @return whether a limit switch stops the axis or has cancelled the last record.
bool is_stopped_by_switch(const Drive& drive) {
  return drive.state().target.given_up || runs_into_limit_switch(drive, demand_velocity(drive));
}

/// A limit switch takes precedence over halt.
MotionRequest ask(const Drive& drive) {
  if (is_stopped_by_switch(drive)) return limit_switch_stop(drive);
  const MotionRequest normal = ramp_stop(drive, "profile_dec"_object);
  if (halted(drive)) {
    return stop_by_option(drive, reg(drive, "halt_option_code"_object), normal);
  }
  return interpolates(drive) && is_streaming(drive) ? follow_position(drive, present_record(drive))
                                                    : normal;
}

/// 6067h and 6068h apply to the last record.
void watch(Drive& drive) {
  watch_target_window(drive);
}

/// @return whether the axis is at the last record and no other record is waiting.
bool is_at_last_record(const Drive& drive) {
  const DriveState& s = drive.state();
  const bool has_way = is_streaming(drive) && drive.registers().interpolation.ticks_left != 0;
  const WindowState& window = s.window;
  return !s.demand.moving && !has_way && waiting_records(drive) == 0 &&
         (window.position == kWindowOff || window.dwell > window.position_ticks);
}

/// Bit 10: the last record is reached, or under halt, standstill; bit 12: interpolation active.
std::uint16_t status_bits(const Drive& drive) {
  const bool reached = halted(drive) ? at_rest(drive) : is_at_last_record(drive);
  const bool is_active = interpolates(drive) && !is_stopped_by_switch(drive);
  return static_cast<std::uint16_t>(reached_when(reached) |
                                    (is_active ? Statusword::kInterpolationActive : 0U));
}

/// Every tick continues the interpolation.
bool evolves(const Drive& drive) {
  return drive.state().power.on;
}

}  // namespace

constinit const Mode kInterpolatedPosition{.normal_ramp = "profile_dec"_object,
                                           .command = command,
                                           .take_target = take_record,
                                           .advance = advance,
                                           .ask = ask,
                                           .watch = watch,
                                           .status_bits = status_bits,
                                           .evolves = evolves};

}  // namespace vdrive
