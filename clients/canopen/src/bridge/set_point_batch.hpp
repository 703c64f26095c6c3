// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/node_host.hpp"
#include "vdrive/client/session.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

namespace vdrive::canopen {

/// Collects the set-points of the nodes of a bench until they are handed over, in as few frames as
/// possible. A set-point that would overtake an earlier one of the same axis, such as a target
/// after a controlword, goes into a later frame: within a tick, frames act in order.
class SetPointBatch {
 public:
  /// The most frames in a batch. Set-points beyond it replace the newest values of their axis: a
  /// flood must not fill the memory, and the newest values matter most.
  static constexpr std::size_t kMostFrames = 64;

  void add(std::uint16_t axis, std::span<const DriveValue> values);

  [[nodiscard]] bool is_empty() const noexcept { return frames_.empty(); }

  /// @return all frames, for the next tick. The batch is then empty.
  [[nodiscard]] std::vector<client::SetPointFrame> take();

  /// @return the number of values replaced before they were handed over, since construction.
  [[nodiscard]] std::uint64_t replaced() const noexcept { return replaced_; }

 private:
  /// The position of the newest set-point of an axis.
  struct Place {
    std::size_t frame = 0;
    std::size_t set_point = 0;
  };

  client::SetPoint* newest_of(std::uint16_t axis);
  client::SetPoint& next_of(std::uint16_t axis);
  [[nodiscard]] bool is_full_for(std::uint16_t axis) const;
  void put(std::uint16_t axis, const client::ObjectValue& value);
  void put_controlword(std::uint16_t axis, std::uint16_t word);

  std::vector<client::SetPointFrame> frames_;
  std::map<std::uint16_t, Place> newest_;
  std::uint64_t replaced_ = 0;
};

}  // namespace vdrive::canopen
