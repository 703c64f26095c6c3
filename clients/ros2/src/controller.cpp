// SPDX-License-Identifier: Apache-2.0
#include "controller.hpp"

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace vdrive::ros2 {
namespace {

using bridge::Severity;
using std::chrono::milliseconds;

// While positions are being streamed, each cycle sends the next ones: the shortest lead is 8 ms.
constexpr milliseconds kBusyTurn{2};
constexpr milliseconds kTurn{5};  // a message wakes it earlier
// Limited, because a service manager or a user waits for the program to end, and a bench may be
// gone.
constexpr std::chrono::seconds kEnd{2};

}  // namespace

Controller::Controller(client::Session& session, const Settings& settings, bridge::Reports& reports,
                       Inbox& inbox, Board& board,
                       const ros::Subscription<ros::JointState>& commands,
                       const wire::Participant& participant)
    : session_(session),
      reports_(reports),
      inbox_(inbox),
      board_(board),
      commands_(commands),
      participant_(participant),
      benches_(session.id(), settings, reports, *this),
      trajectories_(benches_, settings, reports),
      command_stamps_(settings.stamp_ahead),
      drops_(reports),
      thread_([this](const std::stop_token& stop) {
        run(stop);
      }) {}

Controller::~Controller() {
  thread_.request_stop();
  thread_.join();
}

std::vector<client::BenchInfo> Controller::present_benches() {
  return session_.present_benches();
}

std::unique_ptr<FollowedBench> Controller::connect(Bench& bench) {
  // In lock-step a step waits for the set-points; otherwise the next cycle is soon enough.
  const bool is_urgent = bench.info().clock_mode == client::ClockMode::lockstep;
  return std::make_unique<FollowedBench>(session_, bench, reports_, [this, is_urgent] {
    if (is_urgent) inbox_.wake();
  });
}

client::Outcome Controller::send_set_points(std::uint32_t bench,
                                            const SetPointStream::Frames& frames) {
  return session_.send_set_points(bench, frames);
}

void Controller::end_run(BenchMotion& motion) {
  trajectories_.end_with(motion);
}

void Controller::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    turn();
    const bool is_busy = std::ranges::any_of(benches_.all(), [](const auto& entry) {
      return entry.second.motion->is_busy();
    });
    inbox_.wait(is_busy ? kBusyTurn : kTurn, stop);
  }
  end();
}

void Controller::turn() {
  const Clock::time_point now = Clock::now();
  // Benches before messages: a command may name a joint of a bench that has just appeared.
  benches_.find(now);
  handle_messages();
  ask(now);
  update(now);  // before a start, which is planned from the newest state
  trajectories_.start_due();
  update(now);  // sends the first set-points of started trajectories
  trajectories_.forget_ended();
  // Last, so that when the state of a tick is visible, the set-points after it have been sent.
  board_.put(benches_.views(), benches_.any_in_lockstep());
}

void Controller::update(Clock::time_point now) {
  BrokenTrajectories broken;
  for (auto& [number, bench] : benches_.all()) {
    const auto more = bench.motion->update(now);
    broken.insert(broken.end(), more.begin(), more.end());
  }
  trajectories_.break_off(broken);
}

/// An axis must not stay enabled without a master.
void Controller::end() {
  for (auto& [number, bench] : benches_.all()) bench.motion->power().want_enabled(false, false);
  const Clock::time_point deadline = Clock::now() + kEnd;
  const auto is_done = [this] {
    return std::ranges::all_of(benches_.all(), [](const auto& entry) {
      return entry.second.motion->is_disabled();
    });
  };
  while (Clock::now() < deadline) {
    for (auto& [number, bench] : benches_.all()) (void)bench.motion->update(Clock::now());
    if (is_done()) return;
    bridge::rest(kTurn, {});
  }
}

void Controller::handle_messages() {
  const Inbox::Content content = inbox_.take();
  if (content.dropped > 0) {
    reports_.report(Severity::warning, "commands",
                    std::to_string(content.dropped) + " were dropped");
  }
  for (const Received& received : content.messages) {
    std::visit(
        [&](const auto& message) {
          handle(message, received.writer);
        },
        received.message);
  }
}

void Controller::handle(const ros::JointState& message, const wire::WriterId& writer) {
  const JointCommands read =
      read_commands(message, [this](const std::string& name, std::string& problem) {
        return benches_.find_joint(name, problem);
      });
  for (const std::string& problem : read.problems) {
    reports_.report(Severity::warning, "joint commands", problem);
  }
  std::set<std::uint32_t> numbers;
  for (const JointCommand& command : read.commands) numbers.insert(command.joint.bench);
  const std::int64_t stamp = nanoseconds_of(message.header.stamp);
  const std::string problem = stamp_problem(command_stamps_, writer, stamp, benches_, numbers);
  if (!problem.empty()) {
    reports_.report(Severity::warning, "joint commands", problem + ": the command is ignored");
    return;
  }
  // Without a bench that has a time, the stamp cannot be judged.
  const bool is_judged = std::ranges::any_of(numbers, [this](std::uint32_t bench) {
    return benches_.time_of(bench).has_value();
  });
  if (is_judged) command_stamps_.note(writer, stamp);
  for (const JointCommand& command : read.commands) {
    benches_.motion_of(command.joint.bench).command(command);
  }
}

void Controller::handle(const ros::JointTrajectory& message, const wire::WriterId& writer) {
  trajectories_.take(message, writer);
}

void Controller::handle(const ros::Bool& message, const wire::WriterId& /*writer*/) {
  const bool is_enabled = message.data;
  // Enabling is a new start: a stamp from a wrong clock must not lock out a writer for ever.
  command_stamps_.clear();
  trajectories_.note_enable(is_enabled);
  reports_.report(Severity::info, "enable", is_enabled ? "true" : "false");
  benches_.enable(is_enabled);
}

void Controller::ask(Clock::time_point now) {
  note_writers(commands_.matched());
  drops_.report(participant_.guard_counts(), now);
}

/// A velocity or an effort would stay in force with nobody left to end it.
void Controller::note_writers(std::size_t writers) {
  if (writers == 0 && had_writers_) {
    for (auto& [number, bench] : benches_.all()) {
      bench.motion->stop_free_joints("the last publisher of joint commands is gone");
    }
  }
  had_writers_ = writers > 0;
}

}  // namespace vdrive::ros2
