// SPDX-License-Identifier: Apache-2.0
#include "drive/touch_probe.hpp"

#include "drive/frame.hpp"
#include "drive/registers.hpp"
#include "rounding.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// The index pulse, 5E09h, in addition to the bits of 60FDh.
constexpr unsigned kIndexInput = 1U << 3U;

// Bits of 60B8h; those of the second probe are shifted by 8.
constexpr unsigned kProbeEnable = 1U << 0U;
constexpr unsigned kProbeContinuous = 1U << 1U;
constexpr unsigned kProbeSource = 2U;  // the first of two bits

// Bits of 60B9h, likewise.
constexpr unsigned kProbeEnabled = 1U << 0U;

/// Data of one edge of a probe.
struct ProbeEdge {
  unsigned sampled;  // bit of 60B8h
  unsigned stored;   // bit of 60B9h
  ObjectRow position;
  ObjectRow time_stamp;
  ObjectRow counter;
};

struct TouchProbe {
  unsigned shift;  // of its bits
  unsigned input;  // its own input
  ObjectRow source;
  ProbeEdge positive;
  ProbeEdge negative;
};

constexpr std::array kTouchProbes{
    TouchProbe{.shift = 0U,
               .input = kHomeInput,
               .source = "touch_probe_source_1"_object,
               .positive = {.sampled = 1U << 4U,
                            .stored = 1U << 1U,
                            .position = "touch_probe_position_1_positive_value"_object,
                            .time_stamp = "touch_probe_time_stamp_1_positive_value"_object,
                            .counter = "touch_probe_1_positive_edge_counter"_object},
               .negative = {.sampled = 1U << 5U,
                            .stored = 1U << 2U,
                            .position = "touch_probe_position_1_negative_value"_object,
                            .time_stamp = "touch_probe_time_stamp_1_negative_value"_object,
                            .counter = "touch_probe_1_negative_edge_counter"_object}},
    TouchProbe{.shift = 8U,
               .input = kPositiveLimitInput,
               .source = "touch_probe_source_2"_object,
               .positive = {.sampled = 1U << 4U,
                            .stored = 1U << 1U,
                            .position = "touch_probe_position_2_positive_value"_object,
                            .time_stamp = "touch_probe_time_stamp_2_positive_value"_object,
                            .counter = "touch_probe_2_positive_edge_counter"_object},
               .negative = {.sampled = 1U << 5U,
                            .stored = 1U << 2U,
                            .position = "touch_probe_position_2_negative_value"_object,
                            .time_stamp = "touch_probe_time_stamp_2_negative_value"_object,
                            .counter = "touch_probe_2_negative_edge_counter"_object}},
};

/// Inputs that have changed since the last evaluation.
struct InputEdges {
  unsigned rising;
  unsigned falling;
};

/// @return the active inputs of the axis, including the index pulse of the test bench.
unsigned probe_inputs(const Drive& drive) {
  const unsigned index = reg(drive, "test_index_pulse_input"_object) != 0 ? kIndexInput : 0U;
  return active_inputs(drive) | index;
}

/// @return the input selected by 60D0h.
unsigned chosen_input(std::int64_t source) {
  switch (source) {
    case 1:
      return kHomeInput;
    case 2:
      return kPositiveLimitInput;
    case 3:
      return kNegativeLimitInput;
    default:
      return kIndexInput;
  }
}

/// @param bits 60B8h, shifted to the bits of the probe
unsigned input_of(const Drive& drive, const TouchProbe& probe, unsigned bits) {
  switch ((bits >> kProbeSource) & 3U) {
    case 0:
      return probe.input;
    case 1:
      return kIndexInput;
    default:
      return chosen_input(reg(drive, probe.source));
  }
}

/// Stores the present inputs.
/// @return the edges since the last evaluation.
InputEdges next_edges(Drive& drive, double motor_reading) {
  TouchProbeState& state = drive.registers().touch_probe;
  const unsigned before = state.inputs;
  const unsigned now = probe_inputs(drive);
  const double way = motor_reading - state.motor_reading;
  const bool passes = way != 0.0 && index_pulse_passed(drive, way > 0.0 ? 1.0 : -1.0,
                                                       state.motor_reading, motor_reading)
                                        .has_value();
  // A pulse has no width: both of its edges are where it is passed.
  const unsigned pulse = passes ? kIndexInput : 0U;
  state.inputs = static_cast<std::uint8_t>(now);
  state.motor_reading = motor_reading;
  return {.rising = (now & ~before) | pulse, .falling = (before & ~now) | pulse};
}

/// @param bits 60B8h, shifted to the bits of the probe
void take_edge(Drive& drive, const TouchProbe& probe, const ProbeEdge& edge, unsigned bits,
               const ProbeEvaluation& look) {
  auto& values = drive.registers().values;
  const auto status = static_cast<unsigned>(values["touch_probe_status"_object]);
  const unsigned stored = edge.stored << probe.shift;
  const bool waits = (bits & kProbeContinuous) != 0 || (status & stored) == 0;
  if ((bits & edge.sampled) == 0 || !waits) return;
  values[edge.position] = shown_position(drive, nearest(look.position_reading));
  values[edge.time_stamp] = static_cast<std::uint32_t>(look.time_ns);
  values[edge.counter] = static_cast<std::uint16_t>(values[edge.counter] + 1);
  values["touch_probe_status"_object] = status | stored;
}

void look_by(Drive& drive, std::uint16_t function, const ProbeEvaluation& look) {
  const InputEdges edges = next_edges(drive, look.motor_reading);
  if ((edges.rising | edges.falling) == 0) return;
  for (const TouchProbe& probe : kTouchProbes) {
    const unsigned bits = static_cast<unsigned>(function) >> probe.shift;
    if ((bits & kProbeEnable) == 0) continue;
    const unsigned input = input_of(drive, probe, bits);
    if ((edges.rising & input) != 0) take_edge(drive, probe, probe.positive, bits, look);
    if ((edges.falling & input) != 0) take_edge(drive, probe, probe.negative, bits, look);
  }
}

/// The readings between two ticks.
ProbeEvaluation present_look(const Drive& drive) {
  constexpr std::uint64_t kNanosecondsAMicrosecond = 1000;
  const std::size_t l = drive.lane();
  return {.motor_reading = drive.servo().motor_reading[l],
          .position_reading = drive.servo().load_reading[l],
          .time_ns = drive.block().ticks * drive.timing().period_us * kNanosecondsAMicrosecond};
}

/// @param bits 60B8h, shifted to the bits of the probe
/// @param status bits of the probe in 60B9h
/// @return the status after a change of 60B8h: an edge no longer sampled is no longer stored
///         either.
unsigned status_under(const TouchProbe& probe, unsigned bits, unsigned status) {
  if ((bits & kProbeEnable) == 0) return 0;
  unsigned kept = kProbeEnabled;
  for (const ProbeEdge& edge : {probe.positive, probe.negative}) {
    if ((bits & edge.sampled) != 0) kept |= status & edge.stored;
  }
  return kept;
}

bool is_enabled(unsigned function) {
  return (function & (kProbeEnable | kProbeEnable << 8U)) != 0;
}

}  // namespace

void evaluate_inputs(Drive& drive, const ProbeEvaluation& look) {
  look_by(drive, static_cast<std::uint16_t>(reg(drive, "touch_probe_function"_object)), look);
}

void enable_touch_probes(Drive& drive, std::uint16_t previous) {
  // Inputs written before 60B8h belong to the previous function.
  const ProbeEvaluation present = present_look(drive);
  if (is_enabled(previous)) {
    look_by(drive, previous, present);
  } else {
    static_cast<void>(next_edges(drive, present.motor_reading));
  }
  auto& values = drive.registers().values;
  const auto function = static_cast<unsigned>(values["touch_probe_function"_object]);
  const auto before = static_cast<unsigned>(values["touch_probe_status"_object]);
  unsigned status = 0;
  for (const TouchProbe& probe : kTouchProbes) {
    const unsigned bits = function >> probe.shift;
    const unsigned old = static_cast<unsigned>(previous) >> probe.shift;
    if ((bits & ~old & kProbeEnable) != 0) {
      values[probe.positive.counter] = 0;
      values[probe.negative.counter] = 0;
    }
    status |= status_under(probe, bits, before >> probe.shift) << probe.shift;
  }
  values["touch_probe_status"_object] = status;
  std::uint64_t& probed = drive.block().probed;
  const std::uint64_t lane = std::uint64_t{1} << drive.lane();
  probed = is_enabled(function) ? probed | lane : probed & ~lane;
}

void forget_touch_probes(Drive& drive) {
  drive.registers().touch_probe = {};
  drive.block().probed &= ~(std::uint64_t{1} << drive.lane());
}

}  // namespace vdrive
