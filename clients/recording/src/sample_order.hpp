// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"

#include <cstdint>
#include <map>
#include <set>
#include <string>

namespace vdrive::recording {

/// Checks what the samples of a recording have in common, whatever its format: time goes on, and
/// the last tick is whole.
class SampleOrder {
 public:
  /// Takes an axis of a sample, in the order of the file.
  /// @throws RecordingError with axis and ticks when it has this tick already, or its bench a later
  ///         one: a part of the file is repeated, or stands in another place
  void note(const client::AxisId& axis, std::uint64_t tick);

  /// @param last the last sample of the recording
  /// @return what it lacks of the axes that the sample of its bench before it has, such as "the
  ///         tick 7 of bench 1 has 1 of 2 axes"; empty when it is whole.
  [[nodiscard]] std::string shortage(const client::Observation& last) const;

 private:
  /// The axes of a bench that have one tick.
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
