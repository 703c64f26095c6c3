// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <vector>

namespace vdrive::canopen {

/// Counts the values that drives refuse until the thread of the buses takes the counts. Equal
/// refusals share one entry, so that a flood of them does not fill the memory. Thread-safe.
class RefusedSetPoints {
 public:
  struct Count {
    client::SetPointRefusal refusal;
    std::uint64_t count = 0;
  };

  /// @param notify called for the first refusal after each take()
  explicit RefusedSetPoints(std::function<void()> notify);

  void note(const client::SetPointRefusal& refusal);

  /// @return the refusals since the last call, by axis and object.
  [[nodiscard]] std::vector<Count> take();

 private:
  const std::function<void()> notify_;
  std::mutex mutex_;
  std::map<client::SetPointRefusal, std::uint64_t> counts_;
};

}  // namespace vdrive::canopen
