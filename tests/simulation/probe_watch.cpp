// SPDX-License-Identifier: Apache-2.0
#include "simulation/probe_watch.hpp"

#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <limits>
#include <string>

namespace vdrive::simulation {
namespace {

using namespace vdrive::literals;

constexpr std::array<ObjectRow, ProbeWatch::kEdges> kLatchedPositions{
    "touch_probe_position_1_positive_value"_object, "touch_probe_position_1_negative_value"_object,
    "touch_probe_position_2_positive_value"_object, "touch_probe_position_2_negative_value"_object};
constexpr std::array<ObjectRow, ProbeWatch::kEdges> kEdgeCounters{
    "touch_probe_1_positive_edge_counter"_object, "touch_probe_1_negative_edge_counter"_object,
    "touch_probe_2_positive_edge_counter"_object, "touch_probe_2_negative_edge_counter"_object};

/// A tick of 2 ms has 16 sub-steps, each of which may see an edge; a write between two ticks may
/// add one.
constexpr std::uint64_t kMostEdgesATick = 17;

std::string word(unsigned bits) {
  return std::to_string(bits);
}

/// @return the bits of 60B9h that `function`, 60B8h, allows: the enabled probes, and the edges that
///         they sample.
unsigned possible_status(unsigned function) {
  unsigned bits = 0;
  for (const unsigned shift : {0U, 8U}) {
    const unsigned probe = function >> shift;
    if ((probe & 1U) == 0) continue;
    const unsigned edges = (probe >> 4U & 1U) << 1U | (probe >> 5U & 1U) << 2U;
    bits |= (1U | edges) << shift;
  }
  return bits;
}

}  // namespace

ProbeWatch::Look ProbeWatch::look_at(const AxisBank& bank, std::size_t axis) {
  Look look;
  look.function = static_cast<unsigned>(bank.read(axis, "touch_probe_function"_object).value);
  look.status = static_cast<unsigned>(bank.read(axis, "touch_probe_status"_object).value);
  for (std::size_t edge = 0; edge < kEdges; ++edge) {
    look.positions.at(edge) = bank.read(axis, kLatchedPositions.at(edge)).value;
    look.counters.at(edge) =
        static_cast<std::uint16_t>(bank.read(axis, kEdgeCounters.at(edge)).value);
  }
  return look;
}

void ProbeWatch::check(const Look& now, std::uint64_t ticks, Happenings& happenings) {
  check_status(now, happenings);
  check_positions(now, happenings);
  if (has_last_) check_counters(now, ticks, happenings);
  last_ = now;
  has_last_ = true;
}

/// Bits 0 and 8 of 60B9h are those of 60B8h; only an edge that 60B8h samples can be stored.
void ProbeWatch::check_status(const Look& now, Happenings& happenings) const {
  constexpr unsigned kEnabled = 0x0101;
  const unsigned possible = possible_status(now.function);
  if ((now.status & ~possible) != 0 || (now.status & kEnabled) != (possible & kEnabled)) {
    happenings.fail(Invariant::kProbe, number_, "60B9h of 60B8h " + word(now.function),
                    word(now.status));
  }
}

/// A latched position must be one that 6064h can have shown. 0, the value before anything is
/// latched, is one, too.
void ProbeWatch::check_positions(const Look& now, Happenings& happenings) const {
  if (limits_.range_span == 0) return;
  for (const std::int64_t position : now.positions) {
    const std::int64_t place = position - limits_.range_lower;
    if (place < 0 || place >= limits_.range_span) {
      happenings.fail(Invariant::kProbe, number_, "a latched position within 607Bh",
                      std::to_string(position));
    }
  }
}

/// A counter increases, modulo 2^16, or restarts at 0.
void ProbeWatch::check_counters(const Look& now, std::uint64_t ticks,
                                Happenings& happenings) const {
  const std::uint64_t most =
      std::min<std::uint64_t>(ticks * kMostEdgesATick, std::numeric_limits<std::uint16_t>::max());
  for (std::size_t edge = 0; edge < kEdges; ++edge) {
    const std::uint16_t counter = now.counters.at(edge);
    const auto more = static_cast<std::uint16_t>(counter - last_.counters.at(edge));
    if (more > most && counter > most) {
      happenings.fail(Invariant::kProbe, number_,
                      "a counter of at most " + std::to_string(most) + " edges more than " +
                          std::to_string(last_.counters.at(edge)),
                      std::to_string(counter));
    }
  }
}

}  // namespace vdrive::simulation
