// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <vector>

namespace vdrive::canopen {

/// Counts the values that drives refuse until the thread of the buses takes them. Equal ones are
/// one entry, so that a flood of them fills no memory. Thread-safe.
class RefusedSetPoints {
 public:
  struct Count {
    client::SetPointRefusal refusal;
    std::uint64_t count = 0;
  };

  /// @param notify called when the first one waits since the last take()
  explicit RefusedSetPoints(std::function<void()> notify);

  void note(const client::SetPointRefusal& refusal);

  /// @return what was noted since the last call, by axis and object.
  [[nodiscard]] std::vector<Count> take();

 private:
  const std::function<void()> notify_;
  std::mutex mutex_;
  std::map<client::SetPointRefusal, std::uint64_t> counts_;
};

}  // namespace vdrive::canopen
