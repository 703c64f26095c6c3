// SPDX-License-Identifier: Apache-2.0
#include "controller.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace vdrive::ros2 {
namespace {

using bridge::Severity;
using std::chrono::milliseconds;

constexpr milliseconds kBusyTurn{2};
constexpr milliseconds kTurn{5};
constexpr std::chrono::seconds kEnd{2};

}  // namespace

Controller::Controller(client::Session& session, const Settings& settings, bridge::Reports& reports,
                       Board& board)
    : reports_(reports),
      board_(board),
      benches_(session, settings, reports,
               {.notify =
                    [this] {
                      inbox_.wake();
                    },
                .restarted =
                    [this](const BenchMotion& motion) {
                      trajectories_.end_with(motion);
                    }}),
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

void Controller::take(Message message, const wire::WriterId& writer) {
  inbox_.put({.writer = writer, .message = std::move(message)});
}

void Controller::set_questions(Questions questions) {
  const std::scoped_lock lock(mutex_);
  questions_ = std::move(questions);
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
  benches_.find(now);
  handle_messages();
  ask(now);
  update(now);
  trajectories_.start_due();
  update(now);  // sends the first set-points of what has started
  trajectories_.forget_ended();
  board_.put(benches_.views(), benches_.any_in_lockstep());
}

void Controller::update(Clock::time_point now) {
  std::vector<BrokenTrajectory> broken;
  for (auto& [number, bench] : benches_.all()) {
    const auto more = bench.motion->update(now);
    broken.insert(broken.end(), more.begin(), more.end());
  }
  trajectories_.break_off(broken);
}

/// Without a master an axis must not stay enabled.
void Controller::end() {
  for (auto& [number, bench] : benches_.all()) bench.motion->want_enabled(false, false);
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
  const JointCommands read = read_commands(message, [this](const std::string& name) {
    return benches_.find_joint(name);
  });
  for (const std::string& problem : read.problems) {
    reports_.report(Severity::warning, "joint commands", problem);
  }
  std::set<std::uint32_t> numbers;
  for (const JointCommand& command : read.commands) numbers.insert(command.joint.bench);
  const std::int64_t stamp = nanoseconds_of(message.header().stamp());
  const std::string problem = stamp_problem(command_stamps_, writer, stamp, benches_, numbers);
  if (!problem.empty()) {
    reports_.report(Severity::warning, "joint commands", problem + ": the command is ignored");
    return;
  }
  // Without a bench that has a time nobody knows whether the stamp is good.
  const bool is_judged = std::ranges::any_of(numbers, [this](std::uint32_t bench) {
    return benches_.time_of(bench).has_value();
  });
  if (is_judged) command_stamps_.note(writer, stamp);
  for (const JointCommand& command : read.commands) {
    benches_.motion_of(command.joint).command(command);
  }
}

void Controller::handle(const ros::JointTrajectory& message, const wire::WriterId& writer) {
  trajectories_.take(message, writer);
}

void Controller::handle(const ros::Bool& message, const wire::WriterId& /*writer*/) {
  const bool is_enabled = message.data();
  command_stamps_.clear();
  trajectories_.note_enable(is_enabled);
  reports_.report(Severity::info, "enable", is_enabled ? "true" : "false");
  benches_.enable(is_enabled);
}

void Controller::ask(Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  if (questions_.writers) note_writers(questions_.writers());
  if (questions_.guard_counts) drops_.report(questions_.guard_counts(), now);
}

void Controller::note_writers(std::size_t writers) {
  if (writers == 0 && had_writers_) {
    for (auto& [number, bench] : benches_.all()) {
      bench.motion->stop_free_joints("no node writes joint commands");
    }
  }
  had_writers_ = writers > 0;
}

}  // namespace vdrive::ros2
