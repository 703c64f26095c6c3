// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/event_log.hpp"
#include "support/random_cases.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/client.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::bench {

inline constexpr int kCommandsOfAProgram = 16;

/// The record of a program's calls and axes by which two programs are compared.
class ProgramLog {
 public:
  explicit ProgramLog(const test::SessionNumbers& numbers) : numbers_(numbers) {}

  void note(const client::Outcome& outcome);
  void note(const client::Result<client::Observation>& seen);
  void note(const client::Result<client::GroupStatus>& status);
  void note(const client::Result<client::Readings>& readings);

  /// Notes the value of a call, such as the tick that it has reached.
  void note(const client::Result<std::uint64_t>& value) {
    note(value.outcome());
    if (value) text_ << *value << '\n';
  }

  /// Notes that the next result belongs to this command.
  void begin(std::string_view command) { text_ << command << ": "; }

  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  void note(const std::vector<client::AxisSnapshot>& axes);

  const test::SessionNumbers& numbers_;
  std::ostringstream text_;
};

/// @return the first line in which two logs differ, after the preceding lines; empty = none.
[[nodiscard]] std::string difference_of(const std::string& one, const std::string& other);

/// A random program of two sessions in one thread, reproducible from its seed. Its single-axis
/// calls come from the generator; groups, streams, jogging, clocks and snapshots are its own.
class RandomProgram {
 public:
  /// @param second takes axes from the first session, which lets time pass
  RandomProgram(client::Session& first, client::Session& second,
                const test::SessionNumbers& numbers, std::uint32_t seed);

  /// @return the log of the program.
  std::string run();

 private:
  struct Command;
  static constexpr std::int32_t kReach = 20'000;  ///< farthest target from 0 [UU]

  std::uint32_t below(std::size_t count) {
    return static_cast<std::uint32_t>(random_.below(count));
  }

  [[nodiscard]] std::int32_t any_target() {
    return static_cast<std::int32_t>(random_.between(-kReach, kReach));
  }

  [[nodiscard]] client::Axis& any_axis() { return axes_[below(axes_.size())]; }

  void observe();

  // The actions of a program.
  void command();
  void move();
  void write();
  void read();
  void disturb();
  void store();
  void power_cycle();
  void jog();
  void step();
  void send_burst();
  void send_burst_ahead();
  void use_group();
  void stream();
  void take_control();
  void use_second_session();
  void use_clock();
  void use_snapshot();

  void enable_group();
  void send(std::uint64_t first_tick);
  [[nodiscard]] client::SetPoint set_point(std::size_t place, OperatingMode mode,
                                           std::int32_t number);
  [[nodiscard]] Eigen::VectorXd any_targets();

  client::Session& first_;
  client::Session& second_;
  test::Random random_;
  std::vector<client::AxisId> ids_;
  std::vector<client::Axis> axes_;
  std::vector<client::Axis> axes_of_second_;
  std::optional<client::AxisGroup> group_;
  std::optional<client::StepClock> clock_;
  client::Observation seen_;  ///< the newest
  ProgramLog log_;
};

/// A lock-step bench for random programs, two sessions with it, and the events that they receive.
class ProgrammedBench {
 public:
  /// @param first, second sessions of one bench, which has number 1; they outlive this object
  ProgrammedBench(client::Session& first, client::Session& second);
  ~ProgrammedBench();
  ProgrammedBench(const ProgrammedBench&) = delete;
  ProgrammedBench& operator=(const ProgrammedBench&) = delete;

  /// Resets the axes, runs the program of this seed, and waits for the events that it has caused.
  /// @return the log of the program
  /// @throws std::runtime_error if an event does not arrive
  std::string run(std::uint32_t seed);

  /// Waits until its sessions have received the same events and refusals of set-points as those of
  /// another bench. Equal events that a bench leaves out are reported a second later.
  /// @return the first difference after a deadline, or an empty text
  [[nodiscard]] std::string await_same_news(ProgrammedBench& other);

  [[nodiscard]] const test::EventLog& events() const { return events_of_first_; }

  /// @return the refused values of set-points, in the order in which they were reported.
  [[nodiscard]] std::vector<client::SetPointRefusal> refusals() const;

 private:
  [[nodiscard]] std::string difference_from(const ProgrammedBench& other) const;
  void put_back();
  void await_events();
  void cause_equal_events();
  [[nodiscard]] bool is_left_out_after_wait() const;

  client::Session& first_;
  client::Session& second_;
  test::SessionNumbers numbers_;
  test::EventLog events_of_first_;
  test::EventLog events_of_second_;
  std::vector<client::Axis> axes_;
  client::Axis axis_of_second_;
  std::vector<client::AxisId> ids_;
  client::AxisGroup group_;
  std::uint64_t begin_;       ///< a snapshot
  std::uint64_t caused_ = 0;  ///< by cause_equal_events
  mutable std::mutex mutex_;
  std::vector<client::SetPointRefusal> refusals_;  ///< guarded by the mutex
};

}  // namespace vdrive::bench
