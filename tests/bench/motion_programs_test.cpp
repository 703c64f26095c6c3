// SPDX-License-Identifier: Apache-2.0
// Random programs of queued lines, moves, modes and stops with one to six axes. Each call must end
// as the program's own model predicts: after a success the axis is at its target, and a failure
// names the action of the program that caused it. A failing case is printed as a Python program to
// paste; its seed follows from the name and the number of the test.
#include "bench/carry_out.hpp"
#include "support/effort.hpp"
#include "support/programs/generator.hpp"
#include "support/programs/model.hpp"
#include "support/random_cases.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/client/axis_group.hpp"
#include "vdrive/client/session.hpp"

#include <Eigen/Core>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::bench {
namespace {

using namespace std::chrono_literals;
using client::Axis;
using client::AxisGroup;
using client::Motion;
using client::Outcome;
using client::OutcomeKind;
using client::Session;

constexpr std::size_t kMostAxes = 6;
constexpr int kSteps = 12;
constexpr std::int32_t kReach = 3'000;  // the farthest target from 0
constexpr double kRate = 10.0;          // drive time over real time

/// The program's knowledge of an axis beyond its status, which is enough to predict how a call
/// ends.
struct Known {
  bool is_enabled = false;
  bool runs = false;       ///< at a velocity or torque, without an end
  bool is_halted = false;  ///< bit 8 is 1
  bool moves = false;      ///< a move may be in progress
};

/// A move that the program has started.
struct Started {
  std::size_t axis;
  std::int32_t target;
  Motion motion;
  std::string name;     ///< its name in the printed program
  std::string cause{};  ///< the part of its message that names what ends it; empty = it continues
};

/// A random program on a bench in this process.
class MotionProgram {
 public:
  MotionProgram(Session& session, std::vector<Axis> axes, std::uint32_t seed)
      : axes_(std::move(axes)),
        random_(seed),
        known_(axes_.size()),
        group_(AxisGroup::create(session, axes_).value()) {}

  /// @return the first error; empty = none.
  std::string run() {
    using Step = void (MotionProgram::*)();
    static constexpr std::array<Step, 8> kKinds{
        &MotionProgram::line,       &MotionProgram::line,        &MotionProgram::queue,
        &MotionProgram::queue,      &MotionProgram::start_move,  &MotionProgram::start_move,
        &MotionProgram::start_move, &MotionProgram::await_motion};
    for (int step = 0; step < kSteps && error_.empty(); ++step) {
      if (step == 0 || below(3) == 0) enable();
      const Step kind = below(2) == 0 ? &MotionProgram::command : kKinds.at(below(kKinds.size()));
      (this->*kind)();
    }
    while (error_.empty() && !started_.empty()) await_motion();
    return error_;
  }

  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  std::uint32_t below(std::size_t count) {
    return static_cast<std::uint32_t>(random_.below(count));
  }

  std::int32_t any_target() { return static_cast<std::int32_t>(random_.between(-kReach, kReach)); }

  std::size_t any_axis() { return below(axes_.size()); }

  [[nodiscard]] std::string name(std::size_t axis) const {
    return "s.axis(\"" + to_string(axes_[axis].id()) + "\")";
  }

  std::ostringstream& line_of(std::size_t axis) {
    text_ << name(axis) << '.';
    return text_;
  }

  /// Compares the outcome of a call with the expectation.
  /// @param cause expected in the message of a refusal or failure; empty = the call must succeed
  /// @return whether it succeeded
  bool expect(const Outcome& outcome, const std::string& cause) {
    text_ << "  # " << to_string(outcome.kind()) << ' ' << outcome.message() << '\n';
    const bool is_right = outcome ? cause.empty()
                                  : !cause.empty() && outcome.kind() != OutcomeKind::timed_out &&
                                        outcome.message().find(cause) != std::string::npos;
    if (!is_right) {
      error_ = cause.empty() ? "no cause is known for: " + outcome.message()
                             : "expected '" + cause + "': " + outcome.message();
    }
    return static_cast<bool>(outcome);
  }

  void expect_at(std::size_t axis, std::int32_t target) {
    expect_demand(axis, &AxisStatus::position_demand_value, target);
  }

  void expect_demand(std::size_t axis, std::int32_t AxisStatus::*demand, std::int32_t target) {
    const AxisStatus status = axes_[axis].status().value().status;
    const char* const violated =
        test::violated_invariant(status, decode_power_state(status.ds402_statusword));
    if (!error_.empty() || (status.*demand == target && violated == nullptr)) return;
    error_ = violated != nullptr
                 ? violated
                 : "success of axis " + to_string(axes_[axis].id()) + " at " +
                       std::to_string(status.*demand) + " instead of " + std::to_string(target);
  }

  /// Notes that an action of the program ends the moves of the axis.
  void end_moves(std::size_t axis, const std::string& cause) {
    for (Started& started : started_) {
      if (started.axis == axis && started.cause.empty()) started.cause = cause;
    }
    known_[axis].moves = false;
  }

  [[nodiscard]] std::string obstacle(std::size_t axis) const {
    return known_[axis].is_enabled ? "" : "needs Operation enabled";
  }

  /// @return why no line can start; empty = one can.
  [[nodiscard]] std::string obstacle_of_line() const {
    for (const Known& axis : known_) {
      if (!axis.is_enabled) return "needs Operation enabled";
    }
    const bool any_moves = std::ranges::any_of(known_, [](const Known& axis) {
      return (axis.runs || axis.moves) && !axis.is_halted;
    });
    return any_moves ? "still moving" : "";
  }

  // The actions of a program.

  // The axes remain at rest whatever mode and velocity they had, because enabling clears 60FFh.
  void enable() {
    text_ << "g.enable_all()";
    (void)expect(group_.enable_all(), "");
    for (Known& axis : known_) {
      if (!axis.is_enabled) axis = {.is_enabled = true};
    }
  }

  Eigen::VectorXd any_targets() {
    Eigen::VectorXd targets(static_cast<Eigen::Index>(axes_.size()));
    for (double& target : targets) target = any_target();
    return targets;
  }

  void put(const Eigen::VectorXd& targets) {
    text_ << '[';
    for (Eigen::Index i = 0; i < targets.size(); ++i) text_ << (i == 0 ? "" : ", ") << targets[i];
    text_ << ']';
  }

  /// Waits until the axes are at rest. A move that the program has not waited for may or may not
  /// have ended, so the program would not know whether a line is refused or starts.
  void rest() {
    for (std::size_t axis = 0; axis < axes_.size(); ++axis) {
      if (!known_[axis].moves || known_[axis].is_halted) continue;
      const auto rested = axes_[axis].wait_until(
          [](const client::AxisSnapshot& seen) {
            return seen.shows(Statusword::kTargetReached);
          },
          60s);
      if (!rested && error_.empty()) error_ = "no rest: " + rested.outcome().message();
      known_[axis].moves = false;
    }
  }

  void end_line(const Outcome& outcome, const Eigen::VectorXd& last) {
    for (std::size_t axis = 0; axis < axes_.size(); ++axis) {
      end_moves(axis, "superseded by");
      known_[axis] = {.is_enabled = true};
      if (outcome)
        expect_at(axis, static_cast<std::int32_t>(last[static_cast<Eigen::Index>(axis)]));
    }
  }

  void line() {
    rest();
    const Eigen::VectorXd targets = any_targets();
    text_ << "g.move_together(";
    put(targets);
    text_ << ')';
    const Outcome outcome = group_.move_together(targets);
    if (expect(outcome, obstacle_of_line())) end_line(outcome, targets);
  }

  void queue() {
    rest();
    Eigen::VectorXd last;
    for (std::uint32_t count = 2 + below(3); count > 0; --count) {
      last = any_targets();
      text_ << "g.queue_move(";
      put(last);
      text_ << ')';
      (void)expect(group_.queue_move(last), "");
    }
    text_ << "g.wait_all()";
    const Outcome outcome = group_.wait_all();
    if (expect(outcome, obstacle_of_line())) end_line(outcome, last);
  }

  void start_move() {
    const std::size_t axis = any_axis();
    const std::int32_t target = any_target();
    const std::string motion = "m" + std::to_string(++motions_);
    text_ << motion << " = ";
    line_of(axis) << "start_move(" << target << ')';
    const auto started = axes_[axis].start_move(target);
    if (!expect(started.outcome(), obstacle(axis))) return;
    end_moves(axis, "607Ah = " + std::to_string(target));
    known_[axis] = {.is_enabled = true, .moves = true};
    started_.push_back({.axis = axis, .target = target, .motion = *started, .name = motion});
  }

  void await_motion() {
    if (started_.empty()) return;
    const std::size_t place = below(started_.size());
    const Started started = started_[place];
    started_.erase(started_.begin() + static_cast<std::ptrdiff_t>(place));
    text_ << started.name << ".wait()";
    const bool is_halted = started.cause.empty() && known_[started.axis].is_halted;
    if (expect(started.motion.wait(), is_halted ? "was halted" : started.cause)) {
      expect_at(started.axis, started.target);
      known_[started.axis].moves = false;
    }
  }

  void command() {
    using enum test::Intent::Kind;
    static constexpr std::array kIntents{move_to, move_to, run_at,     home,
                                         halt,    resume,  quick_stop, disable};
    const std::size_t axis = any_axis();
    const test::Intent intent = test::draw_intent(kIntents, kReach, random_);
    line_of(axis) << to_string(intent);
    const bool stops = intent.kind == quick_stop || intent.kind == disable;
    if (expect(carry_out(axes_[axis], intent, {}), stops ? "" : obstacle(axis))) {
      note_success(axis, intent);
    }
  }

  void note_success(std::size_t axis, const test::Intent& intent) {
    using enum test::Intent::Kind;
    Known& known = known_[axis];
    switch (intent.kind) {
      case halt:
      case resume:
        known.is_halted = intent.kind == halt;
        break;
      case move_to:
        end_moves(axis, "superseded by");
        known = {.is_enabled = true};
        expect_at(axis, intent.value);
        break;
      case run_at:
        end_moves(axis, "profile velocity mode (6060h = 3)");
        known = {.is_enabled = true, .runs = intent.value != 0};
        expect_demand(axis, &AxisStatus::velocity_demand_value, intent.value);
        break;
      case home:
        end_moves(axis, "homing mode (6060h = 6)");
        known = {.is_enabled = true};
        expect_at(axis, 0);
        break;
      default:
        end_moves(axis, intent.kind == quick_stop ? "quick stop (6040h = 0x0002)"
                                                  : "shutdown (6040h = 0x0006)");
        known = {};
    }
  }

  std::vector<Axis> axes_;
  test::Random random_;
  std::vector<Known> known_;
  AxisGroup group_;
  std::vector<Started> started_;
  int motions_ = 0;
  std::ostringstream text_;
  std::string error_;
};

/// Runs the programs of `count` seeds from `first` on, each on a new bench.
void run_programs(ClockMode clock, std::uint32_t first, int count) {
  const char* const mode = clock == ClockMode::lockstep ? "lockstep" : "realtime";
  for (std::uint32_t seed = first; seed < first + static_cast<std::uint32_t>(count); ++seed) {
    const std::size_t axes = 1 + seed % kMostAxes;
    const Bench bench(
        {.configuration = "watchdog:\n  timeout_ms: 10000\n", .axes = axes, .clock = clock});
    Session session = bench.session();
    if (clock == ClockMode::realtime) session.set_rate(bench.number(), kRate).outcome().or_throw();
    MotionProgram program(session, session.axes(bench.number()).value(), seed);
    const std::string error = program.run();
    ASSERT_EQ(error, "") << "seed " << seed << ":\n\nimport vdrive\nb = vdrive.Bench(axes=" << axes
                         << ", clock=\"" << mode << "\")\ns = b.session()\n"
                         << "g = vdrive.AxisGroup(s, [a.address for a in s.axes()])\n"
                         << program.text();
  }
}

constexpr std::uint32_t kShares = 4;

class MotionPrograms : public testing::TestWithParam<std::uint32_t> {};

TEST_P(MotionPrograms, OfAnySeedInLockStepEndAsTheyHaveTo) {
  const int count = test::number_of<int>({.usual = 8, .full = 2'450, .nightly = 25'000});
  run_programs(ClockMode::lockstep, 1 + GetParam() * 1'000'000, count);
}

INSTANTIATE_TEST_SUITE_P(Share, MotionPrograms, testing::Range(0U, kShares));

// Together with the lock-step shares, a full run has 10,000 programs.
TEST(MotionProgramsInRealTime, OfAnySeedEndAsTheyHaveTo) {
  run_programs(ClockMode::realtime, 500'000,
               test::number_of<int>({.usual = 3, .full = 200, .nightly = 2'000}));
}

}  // namespace
}  // namespace vdrive::bench
