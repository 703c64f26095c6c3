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

/// Collects the set-points of the nodes of a bench until they are handed over. What fits into one
/// frame is one frame. A set-point of an axis that would overtake an earlier one of that axis, such
/// as a target after a controlword, is in a later frame: the frames act in order in one tick.
class SetPointBatch {
 public:
  /// Frames of a batch at most. What comes then replaces the newest values of its axis: a flood
  /// must not fill the memory, and the newest values count.
  static constexpr std::size_t kMostFrames = 64;

  void add(std::uint16_t axis, std::span<const DriveValue> values);

  [[nodiscard]] bool is_empty() const noexcept { return frames_.empty(); }

  /// @return all frames, for the next tick; the batch is empty from then on.
  [[nodiscard]] std::vector<client::SetPointFrame> take();

  /// @return values that were replaced before they were handed over, since it was made.
  [[nodiscard]] std::uint64_t replaced() const noexcept { return replaced_; }

 private:
  /// Where the newest set-point of an axis is.
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
