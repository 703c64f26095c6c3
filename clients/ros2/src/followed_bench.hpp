// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "bench_link.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

namespace vdrive::ros2 {

/// The link of a Bench: passes it states, limits and names of owners, and carries out its wishes.
class FollowedBench final : public bridge::BenchAdapter {
 public:
  /// @param session must outlive this, like `bench` and `reports`
  /// @param notify called on the thread of the link when there is a new state
  FollowedBench(client::Session& session, Bench& bench, bridge::Reports& reports,
                std::function<void()> notify);

 private:
  void on_open(const client::BenchInfo& info, const std::vector<client::Axis>& axes) override;
  void on_state(const State& state) override;
  void on_lost() override;
  void before_turn(bridge::BenchLink& link) override;
  void learn_names(const client::Observation& observation);
  void read_limits(std::uint64_t request);

  client::Session& session_;
  Bench& bench_;
  const std::function<void()> notify_;
  std::vector<client::Axis> axes_;
  std::chrono::steady_clock::time_point limits_due_{};
  bridge::BenchLink link_;  ///< last: its threads use all others
};

}  // namespace vdrive::ros2
