// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/source.hpp"
#include "vdrive/wire/writer_id.hpp"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <vector>

namespace vdrive::wire {

/// A reader or a writer: both have the same kind of identifier.
using EndpointId = WriterId;

/// The endpoints of other participants that match one of ours, with functions to wait for them.
/// Filled by a participant. Thread-safe.
class Matches {
 public:
  void add(const EndpointId& endpoint);
  void remove(const EndpointId& endpoint);

  [[nodiscard]] std::size_t count() const;

  /// @return the participants of the endpoints, in the order in which they matched.
  [[nodiscard]] std::vector<Source> sources() const;

  [[nodiscard]] bool contains(const Source& source) const;

  /// @return false on time-out.
  [[nodiscard]] bool wait_for(std::size_t count, std::chrono::milliseconds timeout);
  [[nodiscard]] bool wait_for(const Source& source, std::chrono::milliseconds timeout);

 private:
  [[nodiscard]] bool has(const Source& source) const;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<EndpointId> endpoints_;
};

}  // namespace vdrive::wire
