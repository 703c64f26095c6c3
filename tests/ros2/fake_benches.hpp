// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fake_bench.hpp"
#include "served_benches.hpp"
#include "trajectories.hpp"

#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <vector>

namespace vdrive::ros2 {

/// Benches without a network, served by the bridge.
struct FakeBenches : BenchAccess {
  explicit FakeBenches(Settings with = {}) : settings(std::move(with)) {}

  Settings settings;
  std::map<std::uint32_t, FakeBench> drives{};  ///< those present
  WrittenReports written{};
  std::vector<const BenchMotion*> restarted{};
  ServedBenches benches{FakeBench::kSession, settings, written.reports, *this};
  Trajectories trajectories{benches, settings, written.reports};
  ServedBenches::Clock::time_point time{std::chrono::hours(1)};

  std::vector<client::BenchInfo> present_benches() override {
    std::vector<client::BenchInfo> present;
    for (const auto& [number, bench] : drives) present.push_back(bench.info());
    return present;
  }

  std::unique_ptr<FollowedBench> connect(Bench& /*bench*/) override { return nullptr; }

  client::Outcome send_set_points(std::uint32_t bench,
                                  const SetPointStream::Frames& frames) override {
    return drives.at(bench).take(frames);
  }

  void end_run(BenchMotion& motion) override {
    restarted.push_back(&motion);
    trajectories.end_with(motion);
  }

  void add(std::uint32_t number, std::vector<std::string> names) {
    drives.emplace(number, FakeBench(std::move(names), number));
  }

  /// Searches for benches, a second after the previous search.
  void find() {
    time += std::chrono::seconds(1);
    benches.find(time);
  }

  BenchMotion& motion(std::uint32_t bench = 1) { return benches.motion_of(bench); }

  /// One turn of the controller.
  void turn() {
    for (auto& [number, bench] : benches.all()) {
      if (drives.contains(number)) drives.at(number).link(*bench.bench);
    }
    update();
    trajectories.start_due();
    update();
    trajectories.forget_ended();
  }

  /// Steps all benches, with a turn after each tick.
  void run(int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
      for (auto& [number, bench] : drives) bench.step();
      turn();
    }
  }

  /// Finds the benches and enables their axes.
  void enable() {
    find();
    benches.enable(true);
    for (auto& [number, bench] : drives) bench.enable();
    turn();
  }

 private:
  void update() {
    BrokenTrajectories broken;
    for (auto& [number, bench] : benches.all()) {
      const auto more = bench.motion->update(time);
      broken.insert(broken.end(), more.begin(), more.end());
    }
    trajectories.break_off(broken);
  }
};

}  // namespace vdrive::ros2
