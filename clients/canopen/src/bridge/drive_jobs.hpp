// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>

namespace vdrive::canopen {

/// What waits to be asked of the drive of one node, in order. Bounded, and what the node asked for
/// last reaches the drive: where NMT commands come faster than a bench answers, a job that changes
/// the drive takes the place of the oldest one of its kind.
class DriveJobs {
 public:
  enum class Kind : std::uint8_t {
    access,      ///< of a master by SDO; refused where too many wait
    connection,  ///< the loss of the master, or its return
    power_cycle,
  };

  using Job = std::function<void()>;

  /// Jobs that may wait, beside one of each kind that changes the drive.
  static constexpr std::size_t kMost = 64;

  /// @return false when the job was refused.
  [[nodiscard]] bool add(Kind kind, Job job);

  /// @return the oldest job. @pre there is one
  [[nodiscard]] Job take();

  [[nodiscard]] bool is_empty() const noexcept { return jobs_.empty(); }

 private:
  struct Waiting {
    Kind kind{};
    Job job;
  };

  std::deque<Waiting> jobs_;
};

}  // namespace vdrive::canopen
