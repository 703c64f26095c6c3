// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_link.hpp"
#include "bench_motion.hpp"
#include "bench_presence.hpp"
#include "board.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::ros2 {

/// A bench that the bridge serves.
struct ServedBench {
  std::shared_ptr<Bench> bench;
  std::unique_ptr<BenchLink> link;
  std::unique_ptr<BenchMotion> motion;
};

/// The benches that the bridge serves, and their joints by name. For one thread.
class ServedBenches {
 public:
  using Clock = std::chrono::steady_clock;
  using Map = std::map<std::uint32_t, ServedBench>;

  struct Calls {
    std::function<std::vector<client::BenchInfo>()> present;  ///< the benches that are there
    std::function<std::unique_ptr<BenchLink>(Bench&)> connect;
    std::function<client::Outcome(std::uint32_t bench, const SetPointStream::Frames&)> send;
    std::function<void(BenchMotion&)> restarted;  ///< these motions end with the run
  };

  /// @param session number of the one that commands the benches
  /// @param reports outlives this
  ServedBenches(std::uint64_t session, const Settings& settings, bridge::Reports& reports,
                Calls calls);

  /// Takes benches that have come, and gives up those that have gone.
  void find(Clock::time_point now);

  /// Enables or disables all axes, also those of benches that come later.
  void enable(bool wanted);

  [[nodiscard]] Map& all() noexcept { return benches_; }

  [[nodiscard]] const Map& all() const noexcept { return benches_; }

  /// @return the joint of that name.
  [[nodiscard]] std::optional<JointPlace> find_joint(const std::string& name) const {
    return directory_.find(name);
  }

  /// The same, as FindJoint. @param problem gets what the directory has instead
  [[nodiscard]] std::optional<JointPlace> find_joint(const std::string& name,
                                                     std::string& problem) const {
    const auto joint = directory_.find(name);
    if (!joint) problem = directory_.unknown(name);
    return joint;
  }

  /// @param bench one of all(), such as that of a joint that was found in this turn
  [[nodiscard]] BenchMotion& motion_of(std::uint32_t bench) const;

  /// @return the time of the newest tick of a bench, as its messages have it [ns]; none without
  ///         one.
  [[nodiscard]] std::optional<std::int64_t> time_of(std::uint32_t bench) const;

  /// @return whether time advances by steps on one of them.
  [[nodiscard]] bool any_in_lockstep() const;

  /// @return what is published of them, and of those that are left out.
  [[nodiscard]] Board::Views views() const;

 private:
  /// A bench that the bridge does not serve, because its joints clash.
  struct LeftOut {
    std::shared_ptr<const Bench> bench;
    std::string reason;
  };

  void add(const client::BenchInfo& info);
  void leave_out(const client::BenchInfo& info, const std::string& reason);
  void remove(std::uint32_t number, bool is_replaced);

  const std::uint64_t session_;
  const Settings settings_;
  bridge::Reports& reports_;
  const Calls calls_;
  bool is_enabled_;
  bridge::Presence presence_;
  Clock::time_point find_due_{};
  Map benches_;
  std::map<std::uint32_t, LeftOut> left_out_;
  JointDirectory directory_;
};

}  // namespace vdrive::ros2
