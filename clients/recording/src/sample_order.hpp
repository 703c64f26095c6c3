// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"

#include <cstdint>
#include <map>
#include <set>
#include <string>

namespace vdrive::recording {

/// Checks required of the samples of every format: time must increase, and the last tick must be
/// complete.
class SampleOrder {
 public:
  /// Checks an axis of a sample, in the order of the file.
  /// @throws RecordingError with axis and ticks if the axis already has this tick, or its bench a
  ///         later one: then a part of the file is repeated or out of place
  void note(const client::AxisId& axis, std::uint64_t tick);

  /// @param last the last sample of the recording
  /// @return a text that says how many axes of the previous sample of its bench are in `last`, such
  ///         as "the tick 7 of bench 1 has 1 of 2 axes"; empty if none is missing.
  [[nodiscard]] std::string shortage(const client::Observation& last) const;

 private:
  /// The axes of a bench with the same tick.
  struct Tick {
    std::uint64_t number = 0;
    std::set<std::uint16_t> axes{};
  };

  struct Ticks {
    Tick before{};
    Tick newest{};
  };

  std::map<std::uint32_t, Ticks> benches_;
};

}  // namespace vdrive::recording
