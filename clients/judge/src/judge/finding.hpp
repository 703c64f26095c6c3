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

/// Where something happened.
struct Place {
  Time time{};
  std::uint64_t tick = 0;  ///< 0 = the source has none
  std::uint64_t line = 0;  ///< likewise

  friend bool operator==(const Place&, const Place&) = default;
};

/// A line of the table around a finding: a change, and how the axis is after it.
struct Line {
  Place place;
  std::optional<Write> write;    ///< of the master; else the drive or the bus has changed
  std::string_view event;        ///< what the bus or the drive did; static
  std::uint16_t event_code = 0;  ///< of an emergency
  std::optional<std::uint16_t> controlword;
  std::optional<std::uint16_t> statusword;
  std::optional<std::int8_t> mode;
  std::optional<std::int32_t> target;
  std::optional<std::int32_t> actual;
  Waiting waiting = Waiting::nothing;
};

/// A point of the picture around a finding.
struct Sample {
  Time time{};
  std::optional<std::int32_t> position;
  std::optional<std::int32_t> demand;
  std::optional<std::int32_t> target;
  std::uint16_t statusword = 0;
};

/// A rule that a master has broken on an axis, once for all times that it did.
struct Finding {
  Rule rule{};
  std::uint32_t axis = 0;
  std::uint64_t count = 0;
  Place first;
  Place last;
  std::string happened;         ///< the first time
  std::vector<Line> lines;      ///< around the first time, oldest first
  std::vector<Sample> samples;  ///< likewise
};

}  // namespace vdrive::judge
