// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joint_limits.hpp"
#include "joints.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/session_name.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::ros2 {

/// A request of the commanding thread to take, keep or release the control of the axes of a bench.
enum class ControlWish : std::uint8_t {
  take,       ///< as soon as they are free
  leave,      ///< keep the axes held, take no further ones
  give_back,  ///< release the axes held
};

/// A bench as shared by two threads: the one that commands it and never waits, and the one of its
/// FollowedBench, which may wait for answers of the bench. Thread-safe; no call waits.
class Bench {
 public:
  using State = std::shared_ptr<const client::Observation>;  ///< axes in the order of the joints
  using Limits = std::shared_ptr<const std::vector<JointLimits>>;
  using Names = std::map<std::uint64_t, client::SessionName>;

  /// The newest information about the bench.
  struct Seen {
    State state{};                         ///< the newest one; null while the bench sends no status
    Limits limits{};                       ///< of all joints; null before they were read
    std::uint64_t limits_read = 0;         ///< number of the newest request that `limits` answers
    std::shared_ptr<const Names> names{};  ///< of other sessions that hold axes; null = no names
    double rate = 1.0;  ///< drive time over wall time; 1 if time passes only by steps
  };

  /// Requests to the bench.
  struct Wishes {
    std::optional<ControlWish> control{};  ///< each is taken once
    std::uint64_t limits = 0;              ///< number of the newest request
  };

  Bench(client::BenchInfo info, std::vector<ServedJoint> joints);

  [[nodiscard]] const client::BenchInfo& info() const noexcept { return info_; }

  [[nodiscard]] const std::vector<ServedJoint>& joints() const noexcept { return joints_; }

  /// @return its name in reports, such as "bench 1".
  [[nodiscard]] std::string label() const { return "bench " + std::to_string(info_.number); }

  /// @return [s] of a tick
  [[nodiscard]] double period() const noexcept {
    return std::chrono::duration<double>(info_.period).count();
  }

  [[nodiscard]] Seen seen() const;
  void set_state(State state);
  void set_rate(double rate);

  /// Records the name of a session that holds axes.
  void add_name(std::uint64_t session, client::SessionName name);

  /// @param request Wishes::limits as taken before the limits were read
  void set_limits(Limits limits, std::uint64_t request);

  /// A newer wish replaces one that has not been taken yet.
  void wish(ControlWish wish);

  /// Requests that the limits be read again.
  /// @return the value of Seen::limits_read once that is done.
  std::uint64_t request_limits();

  [[nodiscard]] Wishes take_wishes();

 private:
  const client::BenchInfo info_;
  const std::vector<ServedJoint> joints_;
  mutable std::mutex mutex_;  ///< guards the members below
  Seen seen_;
  Wishes wishes_;
};

/// @return the name, for messages, of a session that holds axes of a bench.
[[nodiscard]] std::string owner_text(std::uint64_t session, const Bench::Names* names);

/// A joint in the newest tick of its bench, for the duration of a call.
struct JointCycle {
  const ServedJoint& joint;
  const client::AxisSnapshot& axis;
  const JointLimits& limits;
  std::uint64_t tick = 0;
  double period = 0.0;  ///< [s] of a tick

  /// @return the motion that the drive commands in this tick.
  [[nodiscard]] JointMotion demand() const noexcept;

  /// @return `value`, given in rad or m, in user units.
  [[nodiscard]] std::int32_t user_units(double value) const noexcept;

  /// @return the time [s] from one tick to another, which may be earlier.
  [[nodiscard]] double seconds(std::uint64_t from, std::uint64_t to) const noexcept {
    return (static_cast<double>(to) - static_cast<double>(from)) * period;
  }
};

/// A bench in one cycle.
struct BenchCycle {
  const Bench& bench;
  Bench::Seen seen{};

  [[nodiscard]] std::uint64_t tick() const noexcept { return seen.state->tick; }

  /// @return the joint at that place. Only if the joint can be commanded: there must be a state and
  ///         limits.
  [[nodiscard]] JointCycle joint(std::size_t place) const;
};

}  // namespace vdrive::ros2
