// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clock/cycle_timer.hpp"
#include "clock/freerun_driver.hpp"
#include "clock/realtime_driver.hpp"
#include "engine/bench_engine.hpp"
#include "simulation/control_model.hpp"
#include "simulation/disk.hpp"
#include "simulation/happenings.hpp"
#include "simulation/network.hpp"
#include "simulation/probe_watch.hpp"
#include "simulation/store_model.hpp"
#include "store/parameter_saver.hpp"
#include "support/local_inbox.hpp"
#include "support/programs/generator.hpp"
#include "support/programs/model.hpp"

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace vdrive::simulation {

/// The faults of a broken service; the checks must detect each of them.
enum class Sabotage : std::uint8_t {
  none,
  motion_without_power,
  push_without_power,
  position_jump,
  speed_beyond_limit,
  torque_beyond_limit,
  error_code_without_fault,
  wrong_state,
  bits_of_another_mode,
  counts_back,
  restores_otherwise,
  resumes_by_itself,
  two_owners,
  accepts_stale_epochs,
  accepts_old_incarnations,
  executes_doubles,
  forgets_an_answer,
  answers_twice,
  watchdog_sleeps,
  watchdog_bites_early,
  no_reaction_to_a_loss,
  stores_half,
  hides_store_failures,
  syncs_nothing,
};

/// Simulated time; it passes only while the bench waits for it.
class SimulatedTime final : public service::CycleTimer {
 public:
  static constexpr std::int64_t kWall = 1'000'000 * std::int64_t{1'000'000'000};

  /// `wake` is called with the current time before the bench reads the messages that have arrived.
  void on_wake(std::function<void(std::int64_t)> wake) { wake_ = std::move(wake); }

  [[nodiscard]] std::chrono::nanoseconds monotonic_now() noexcept override {
    return std::chrono::nanoseconds{now};
  }

  [[nodiscard]] std::chrono::nanoseconds wall_now() noexcept override {
    return std::chrono::nanoseconds{kWall + now};
  }

  void wait_until(std::chrono::nanoseconds deadline) noexcept override {
    now = std::max(now, deadline.count()) + late;
    late = 0;
    wake_(now);
  }

  std::int64_t now = 0;
  std::int64_t late = 0;  ///< the next wait returns late by this much

 private:
  std::function<void(std::int64_t)> wake_;
};

/// Everything that outlasts the service: the disk of its host, and the content that it must have.
struct Storage {
  explicit Storage(std::uint64_t seed) : disk(seed), random(seed ^ 1U) {}

  Disk disk;
  StoreModel model;
  Random random;  ///< for the times at which the saver runs
};

/// Where the messages of the bench to its clients go.
struct Mail {
  std::function<void(const msg::Reply&)> reply;
  std::function<void(const msg::CommandReply&)> command_reply;
};

/// One run of the service from start to end: the real engine with the real driver of its clock, its
/// model, and the watches of its axes.
class Bench {
 public:
  Bench(const service::Configuration& configuration, const std::vector<test::DrawnAxis>& axes,
        std::uint64_t incarnation, SimulatedTime& time, Storage* storage, Sabotage sabotage,
        Happenings& happenings);

  /// Puts the message into the inbox, as the network does.
  void receive(const ClientMessage& message);

  /// Runs one cycle of the driver and checks its result. Does nothing if the service ended in a
  /// save.
  void cycle(const Mail& mail);

  /// Holds answers back until `until`.
  void hold_answers(std::int64_t until) { answers_held_until_ = until; }

  [[nodiscard]] ControlModel& model() { return model_; }

  [[nodiscard]] std::uint64_t incarnation() const { return incarnation_; }

  [[nodiscard]] const service::StatusImage& image() const { return image_; }

  [[nodiscard]] const service::Counters& counters() const { return counters_; }

  /// Whether the process ended in a save.
  [[nodiscard]] bool was_killed() const {
    return storage_ != nullptr && storage_->disk.is_killed();
  }

  [[nodiscard]] double rate() const { return engine_.rate(); }

 private:
  void start_storage();
  void save();
  void take_back_stores();
  void count_arrivals();
  void cycle_lockstep();
  void step_by_request(service::Arrival& arrival);
  void after_tick();
  void evaluate_probes();
  void check_repeat();
  void take_images();
  void spoil(service::StatusImage& image);
  bool spoil(const ClientMessage& message);
  void enable_unrequested();
  void take_events();
  void take_parameters();
  void take_answers(const Mail& mail);

  const service::Configuration& configuration_;
  std::uint64_t incarnation_;
  SimulatedTime& time_;
  Storage* storage_;  ///< nullptr = no state directory
  Sabotage sabotage_;
  Happenings& happenings_;
  service::Counters counters_;
  test::LocalInbox inbox_;
  service::Outbox outbox_;
  service::Configuration as_started_;  ///< including the stored parameters
  std::optional<service::ParameterSaver> saver_;
  StoredSet loaded_;
  service::BenchEngine engine_;
  std::optional<service::RealtimeDriver> realtime_;
  std::optional<service::FreerunDriver> freerun_;
  ControlModel model_;
  std::vector<test::AxisWatch> watches_;
  std::vector<ProbeWatch> probes_;
  std::deque<ClientMessage> in_inbox_;  ///< as they were sent
  service::StatusImage image_;          ///< of the last tick
  std::int64_t answers_held_until_ = 0;
  std::optional<std::int64_t> save_at_;
  std::uint64_t idle_stores_ = 0;  ///< cycles in which no saved order was taken back
  std::uint64_t turned_away_ = 0;
  std::uint64_t spoiled_ = 0;
  std::uint64_t unrequested_ = 0;  ///< requests without a sender
  std::uint64_t current_sequence_ = 0;
};

}  // namespace vdrive::simulation
