// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bridge/canopen_bridge.hpp"
#include "canopen/test_master.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/client.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::test {

/// A bridge without an external connection: the nodes of its bus are the axes of a bench in this
/// process, and a test master is attached to it.
class BusOfBench {
 public:
  /// @param sync_steps drive time per SYNC; std::nullopt = the bench runs in real time
  /// @param directory where 1010h stores parameters; empty = in memory
  explicit BusOfBench(std::size_t axes, std::optional<std::chrono::microseconds> sync_steps = {},
                      const std::string& directory = "")
      : bench_options_{.axes = axes,
                       .clock = sync_steps ? ClockMode::lockstep : ClockMode::realtime,
                       .state_directory = directory},
        bench_(std::in_place, bench_options_),
        bridge_(settings(*bench_, sync_steps, directory)),
        master_(bridge_.bus(0).bus(), [this] {
          bridge_.loop().run_one_for(std::chrono::milliseconds(10));
        }) {
    bench_options_.bus = bench_->bus();
    bridge_.start();
  }

  [[nodiscard]] canopen::CanopenBridge& bridge() noexcept { return bridge_; }

  [[nodiscard]] TestMaster& master() noexcept { return master_; }

  [[nodiscard]] const canopen::BenchNodes& nodes() { return *bridge_.bus(0).nodes(1); }

  /// @return a session of another client.
  [[nodiscard]] client::Session other_session() const { return bench_->session(); }

  void end_bench() { bench_.reset(); }

  void begin_bench() { bench_.emplace(bench_options_); }

  /// Sends SYNCs, each of which lets one period pass.
  void sync(int count = 1) {
    for (int i = 0; i < count; ++i) master_.send_sync();
  }

  [[nodiscard]] std::int64_t read(std::uint8_t node, ObjectAddress object, bool is_signed = false) {
    return master_.upload(node, object).number(is_signed);
  }

  [[nodiscard]] std::uint16_t statusword(std::uint8_t node) {
    return static_cast<std::uint16_t>(read(node, {0x6041, 0}));
  }

 private:
  static canopen::Settings settings(const bench::Bench& bench,
                                    std::optional<std::chrono::microseconds> sync_steps,
                                    const std::string& directory) {
    canopen::Settings settings;
    settings.session.bus = bench.bus();
    settings.sync_steps = sync_steps;
    settings.state = directory;
    settings.buses.emplace_back().benches.push_back({.number = 1});
    return settings;
  }

  bench::BenchOptions bench_options_;
  std::optional<bench::Bench> bench_;
  canopen::CanopenBridge bridge_;
  TestMaster master_;
};

// Bits 0 to 3, 5 and 6 of 6041h: the power state (CiA 402).
inline constexpr std::uint16_t kStateBits = 0x006F;
inline constexpr std::uint16_t kShowsEnabled = 0x0027;
inline constexpr std::uint16_t kShowsFault = 0x0008;
inline constexpr std::uint16_t kShowsRemote = 0x0200;
inline constexpr std::uint16_t kShowsTargetReached = 0x0400;
inline constexpr std::uint16_t kShowsAcknowledge = 0x1000;

}  // namespace vdrive::test
