// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "simulation/bench.hpp"
#include "simulation/disk.hpp"
#include "simulation/master.hpp"
#include "simulation/network.hpp"
#include "support/random_cases.hpp"

#include <cstdint>
#include <vector>

namespace vdrive::simulation {

using test::Random;

/// The disturbances of the bench, apart from its masters.
struct Disturbances {
  bool restarts = true;    ///< of the service
  bool test_bench = true;  ///< inputs 5E00h to 5E0Ah, power cycles, snapshots, the rate
  bool host = true;        ///< a clock that stalls, answers that leave late, floods
  bool disk = true;        ///< stores, and a disk that is full, fails or outlives the service
};

/// The test bench and the host: disturbs axes and clears the disturbances, cycles their power,
/// takes and restores snapshots, pauses time; stalls the clock, floods the network and restarts the
/// service.
class Disturber {
 public:
  Disturber(std::size_t place, const Disturbances& which, std::uint64_t seed, Disk& disk,
            Happenings& happenings);

  [[nodiscard]] std::int64_t next_action() const { return next_; }

  /// Makes one disturbance.
  void act(const View& view, Bench& bench, SimulatedTime& time, Post& post);

  void on(const msg::Reply& reply);

  /// @return whether the service must be restarted now; true only once.
  [[nodiscard]] bool wants_restart();

 private:
  struct Disturbance;
  struct Present;

  static const std::vector<Disturbance>& disturbances();

  void set_input(const Present& present);
  void heal(const Present& present);
  void power_cycle(const Present& present);
  void take_snapshot(const Present& present);
  void restore_snapshot(const Present& present);
  void drop_snapshot(const Present& present);
  void change_rate(const Present& present);
  void read(const Present& present);
  void stall(const Present& present);
  void hold_answers(const Present& present);
  void flood(const Present& present);
  void restart(const Present& present);
  void store(const Present& present);
  void fill_disk(const Present& present);
  void fail_save(const Present& present);
  void kill_in_save(const Present& present);

  msg::Request new_request(msg::RequestKind kind);
  void post(msg::Request request, const Present& present);

  struct Ailment {
    std::uint16_t axis = 0;
    std::uint16_t index = 0;
  };

  std::size_t place_;
  Disturbances which_;
  Random random_;
  Disk& disk_;
  Happenings& happenings_;
  std::int64_t now_ = 0;
  std::int64_t next_ = 0;
  std::uint64_t client_;
  std::uint64_t last_request_ = 0;
  std::uint64_t last_snapshot_ = 0;
  std::vector<Ailment> ailments_;
  bool wants_restart_ = false;
};

}  // namespace vdrive::simulation
