// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/node_host.hpp"

#include <span>
#include <vector>

namespace vdrive::canopen {

/// Set-points of RPDOs that act together in one tick, as NodeHost::command() takes them: each
/// object once with the value that came last, in order of arrival, the controlword (6040h) behind
/// all others.
class SetPoints {
 public:
  void put(const DriveValue& value);

  void clear() noexcept { values_.clear(); }

  /// The span ends with the next put() or clear().
  [[nodiscard]] std::span<const DriveValue> values() const noexcept { return values_; }

 private:
  std::vector<DriveValue> values_;
};

}  // namespace vdrive::canopen
