// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/axis_track.hpp"
#include "judge/record.hpp"
#include "judge/rule.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::judge {

/// The place of an event in its source.
struct Place {
  Time time{};
  std::uint64_t tick = 0;  ///< 0 = the source has no ticks
  std::uint64_t line = 0;  ///< 0 = the source has no lines

  friend bool operator==(const Place&, const Place&) = default;
};

/// A line of the table around a finding: a change, and the state of the axis after it.
struct Line {
  Place place;
  std::optional<Write> write;    ///< by the master; otherwise a change of drive or bus
  std::string_view event;        ///< the event on the bus or in the drive; static
  std::uint16_t event_code = 0;  ///< of an emergency
  std::optional<std::uint16_t> controlword;
  std::optional<std::uint16_t> statusword;
  std::optional<std::int8_t> mode;
  std::optional<std::int32_t> target;
  std::optional<std::int32_t> actual;
  Waiting waiting = Waiting::nothing;
};

/// A point of the plot around a finding.
struct Sample {
  Time time{};
  std::optional<std::int32_t> position;
  std::optional<std::int32_t> demand;
  std::optional<std::int32_t> target;
  std::uint16_t statusword = 0;
};

/// A rule that a master has broken on an axis; one finding for all occurrences.
struct Finding {
  Rule rule{};
  std::uint32_t axis = 0;
  std::uint64_t count = 0;
  Place first;
  Place last;
  std::string happened;         ///< the first occurrence, or the last one if RuleRow::is_figure
  std::vector<Line> lines;      ///< around the first occurrence, oldest first
  std::vector<Sample> samples;  ///< around the first occurrence, oldest first
};

}  // namespace vdrive::judge
