// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_motion.hpp"
#include "board.hpp"
#include "followed_bench.hpp"
#include "roster.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::ros2 {

/// A bench served by the bridge.
struct ServedBench {
  std::shared_ptr<Bench> bench;
  std::unique_ptr<FollowedBench> link;
  std::unique_ptr<BenchMotion> motion;
};

/// The operations that ServedBenches needs from the bridge.
class BenchAccess {
 public:
  virtual ~BenchAccess() = default;

  virtual std::vector<client::BenchInfo> present_benches() = 0;

  /// Starts following the bench.
  virtual std::unique_ptr<FollowedBench> connect(Bench& bench) = 0;

  /// Sends set-points to a bench.
  virtual client::Outcome send_set_points(std::uint32_t bench,
                                          const SetPointStream::Frames& frames) = 0;

  /// Ends the trajectories of a bench whose run has ended.
  virtual void end_run(BenchMotion& motion) = 0;
};

/// The benches that the bridge serves, and their joints by name. For one thread.
class ServedBenches final : private bridge::BenchHost {
 public:
  using Clock = std::chrono::steady_clock;
  using Map = std::map<std::uint32_t, ServedBench>;

  /// @param session number of the session that commands the benches
  /// @param reports, access must outlive this
  ServedBenches(std::uint64_t session, const Settings& settings, bridge::Reports& reports,
                BenchAccess& access);

  /// Adds benches that have appeared, and removes those that have gone.
  void find(Clock::time_point now);

  /// Enables or disables all axes, also those of benches found later.
  void enable(bool wanted);

  [[nodiscard]] Map& all() noexcept { return benches_; }

  [[nodiscard]] const Map& all() const noexcept { return benches_; }

  [[nodiscard]] std::optional<JointPlace> find_joint(const std::string& name) const {
    return directory_.find(name);
  }

  /// As above, in the form of FindJoint.
  /// @param problem receives the reason if the name is unknown
  [[nodiscard]] std::optional<JointPlace> find_joint(const std::string& name,
                                                     std::string& problem) const {
    const auto joint = directory_.find(name);
    if (!joint) problem = directory_.unknown(name);
    return joint;
  }

  /// @param bench one of all(), such as that of a joint found in this cycle
  [[nodiscard]] BenchMotion& motion_of(std::uint32_t bench) const;

  /// @return the time of the newest tick of a bench, as in its messages [ns]; nothing without one.
  [[nodiscard]] std::optional<std::int64_t> time_of(std::uint32_t bench) const;

  /// @return whether one of the benches advances by steps.
  [[nodiscard]] bool any_in_lockstep() const;

  /// @return the published data of these benches, and of those that are left out.
  [[nodiscard]] Board::Views views() const;

 private:
  [[nodiscard]] bool continues(const client::BenchInfo& known,
                               const client::BenchInfo& found) const override;
  std::optional<std::string> add(const client::BenchInfo& info) override;
  void leave_out(const client::BenchInfo& info, const std::string& reason) override;
  void remove(std::uint32_t number, bool is_replaced) override;

  const std::uint64_t session_;
  const Settings settings_;
  bridge::Reports& reports_;
  BenchAccess& access_;
  bool is_enabled_;
  bridge::Roster roster_;
  Clock::time_point find_due_{};
  Map benches_;
  Board::Views left_out_;  ///< benches whose joints clash, as they were when found
  JointDirectory directory_;
};

}  // namespace vdrive::ros2
