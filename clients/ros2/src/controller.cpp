// SPDX-License-Identifier: Apache-2.0
#include "controller.hpp"

#include "topic_names.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdrive::ros2 {
namespace {

using bridge::Severity;
using std::chrono::milliseconds;

constexpr milliseconds kFindPeriod{200};
constexpr milliseconds kBusyTurn{2};
constexpr milliseconds kTurn{5};
constexpr std::chrono::seconds kEnd{2};
constexpr std::size_t kMostMessages = 64;
constexpr double kNanosecond = 1e-9;

std::string joined(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  return names.size() > kMost ? text + " and " + std::to_string(names.size() - kMost) + " more"
                              : text;
}

/// The plans of a bench end with its run.
bool is_same_run(const client::BenchInfo& known, const client::BenchInfo& found) {
  return known.incarnation == found.incarnation && bridge::are_same_axes(known.axes, found.axes);
}

}  // namespace

Controller::Controller(client::Session& session, const Settings& settings, bridge::Reports& reports,
                       Board& board)
    : session_(session),
      settings_(settings),
      reports_(reports),
      board_(board),
      presence_({.continues = is_same_run, .wanted = settings.benches}),
      command_stamps_(settings.stamp_ahead),
      trajectory_stamps_(settings.stamp_ahead),
      drops_(reports),
      is_enabled_(settings.is_enabled),
      thread_([this](const std::stop_token& stop) {
        run(stop);
      }) {}

Controller::~Controller() {
  thread_.request_stop();
  thread_.join();
}

void Controller::take(Message message, const wire::WriterId& writer) {
  const std::scoped_lock lock(mutex_);
  if (messages_.size() >= kMostMessages) {
    messages_.pop_front();
    ++dropped_;
  }
  messages_.push_back({.writer = writer, .message = std::move(message)});
  is_woken_ = true;
  woken_.notify_one();
}

void Controller::set_writers(std::function<std::size_t()> writers) {
  const std::scoped_lock lock(mutex_);
  writers_ = std::move(writers);
}

void Controller::set_guard_counts(std::function<wire::GuardCounts()> counts) {
  const std::scoped_lock lock(mutex_);
  guard_counts_ = std::move(counts);
}

void Controller::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    turn();
    wait(stop);
  }
  end();
}

void Controller::turn() {
  const Clock::time_point now = Clock::now();
  find_benches(now);
  handle_messages();
  check_writers();
  report_drops(now);
  std::vector<BrokenTrajectory> broken;
  const auto update = [&] {
    for (auto& [number, bench] : benches_) {
      const auto more = bench.motion->update(now);
      broken.insert(broken.end(), more.begin(), more.end());
    }
  };
  update();
  break_off(broken);
  start_waiting();
  broken.clear();
  update();
  break_off(broken);
  forget_trajectories();
  publish(std::ranges::any_of(benches_, [](const auto& entry) {
    return entry.second.info->clock_mode == client::ClockMode::lockstep;
  }));
}

void Controller::wait(const std::stop_token& stop) {
  const bool is_busy = std::ranges::any_of(benches_, [](const auto& entry) {
    return entry.second.motion->is_busy();
  });
  std::unique_lock lock(mutex_);
  woken_.wait_for(lock, stop, is_busy ? kBusyTurn : kTurn, [this] {
    return is_woken_;
  });
  is_woken_ = false;
}

/// Without a master an axis must not stay enabled.
void Controller::end() {
  for (auto& [number, bench] : benches_) bench.motion->want_enabled(false, false);
  const Clock::time_point deadline = Clock::now() + kEnd;
  const auto is_done = [this] {
    return std::ranges::all_of(benches_, [](const auto& entry) {
      return entry.second.motion->is_disabled();
    });
  };
  std::mutex mutex;
  std::condition_variable never;
  while (Clock::now() < deadline) {
    for (auto& [number, bench] : benches_) (void)bench.motion->update(Clock::now());
    if (is_done()) return;
    std::unique_lock lock(mutex);
    never.wait_for(lock, kTurn);
  }
}

// ---- benches ---------------------------------------------------------------------------------

void Controller::find_benches(Clock::time_point now) {
  if (now < find_due_) return;
  find_due_ = now + kFindPeriod;
  const std::vector<client::BenchInfo> present = session_.present_benches();
  const auto is_present = [&present](std::uint32_t number) {
    return std::ranges::count(present, number, &client::BenchInfo::number) > 0;
  };
  std::erase_if(left_out_, [&](const auto& entry) {
    return !is_present(entry.first);
  });
  using Kind = bridge::PresenceChange::Kind;
  for (const bridge::PresenceChange& change : presence_.take(present, now)) {
    if (change.kind == Kind::went || change.kind == Kind::replaced) {
      remove_bench(change.bench, change.kind == Kind::replaced);
    }
  }
  // Also a bench that was left out: another one may have set its names free.
  for (const bridge::BenchRecord& record : presence_.all()) {
    const client::BenchInfo& info = record.info;
    const auto known = benches_.find(info.number);
    if (known == benches_.end()) {
      if (is_present(info.number)) add_bench(info);
    } else if (info.clock_mode == client::ClockMode::realtime && info.rate > 0.0) {
      known->second.link->set_rate(info.rate);
    }
  }
}

void Controller::remove_bench(std::uint32_t number, bool is_replaced) {
  const auto known = benches_.find(number);
  if (known == benches_.end()) return;
  const std::string name = known->second.link->name();
  directory_.remove(number);
  for (const auto& [trajectory, text] : trajectories_) {
    if (!is_replaced || !known->second.motion->follows(trajectory)) continue;
    break_off({{.number = trajectory, .reason = name + " was restarted"}});
    break;
  }
  benches_.erase(known);
  if (is_replaced) reports_.report(Severity::warning, name, "was restarted");
}

void Controller::add_bench(const client::BenchInfo& info) {
  std::vector<Joint> joints = joints_of(info, settings_);
  if (const auto clash = directory_.add(info.number, joints)) {
    LeftOut& left_out = left_out_[info.number];
    if (left_out.reason != *clash || left_out.info->incarnation != info.incarnation) {
      reports_.report(Severity::error, "bench " + std::to_string(info.number), *clash);
    }
    left_out = {.info = std::make_shared<const client::BenchInfo>(info), .reason = *clash};
    return;
  }
  left_out_.erase(info.number);
  Bench bench;
  bench.info = std::make_shared<const client::BenchInfo>(info);
  bench.joints = std::make_shared<const std::vector<Joint>>(joints);
  const bool is_urgent = info.clock_mode == client::ClockMode::lockstep;
  bench.link =
      std::make_unique<BenchLink>(session_, info, std::move(joints), reports_, [this, is_urgent] {
        if (!is_urgent) return;
        const std::scoped_lock lock(mutex_);
        is_woken_ = true;
        woken_.notify_one();
      });
  bench.motion =
      std::make_unique<BenchMotion>(session_, *bench.link, reports_, settings_.command_timeout);
  if (settings_.is_enabled && is_enabled_) bench.motion->want_enabled(true, false);
  reports_.report(Severity::info, bench.link->name(),
                  "found, " + std::to_string(info.axes.size()) + " joints");
  benches_.emplace(info.number, std::move(bench));
}

std::optional<KnownJoint> Controller::find(const std::string& name) const {
  const auto place = directory_.find(name);
  if (!place) return std::nullopt;
  return KnownJoint{.place = *place,
                    .interface = (*benches_.at(place->bench).joints)[place->place].interface};
}

// ---- messages --------------------------------------------------------------------------------

void Controller::handle_messages() {
  std::deque<Received> messages;
  std::uint64_t dropped = 0;
  {
    const std::scoped_lock lock(mutex_);
    messages.swap(messages_);
    dropped = std::exchange(dropped_, 0);
  }
  if (dropped > 0) {
    reports_.report(Severity::warning, "commands", std::to_string(dropped) + " were dropped");
  }
  for (const Received& received : messages) {
    std::visit(
        [&](const auto& content) {
          handle(content, received.writer);
        },
        received.message);
  }
}

/// @return the time of the newest tick of a bench, as its messages have it [ns]; none without one.
std::optional<std::int64_t> Controller::time_of(std::uint32_t bench) const {
  const auto known = benches_.find(bench);
  if (known == benches_.end() || !known->second.motion->state()) return std::nullopt;
  return stamp_of(*known->second.info, known->second.motion->state()->tick);
}

/// Compares with the time of each bench: in lock-step each has its own.
std::string Controller::stamp_problem(const StampOrder& order, const wire::WriterId& writer,
                                      std::int64_t stamp,
                                      const std::set<std::uint32_t>& benches) const {
  for (const std::uint32_t bench : benches) {
    const std::string problem = order.problem(writer, stamp, time_of(bench));
    if (!problem.empty()) return problem;
  }
  return {};
}

void Controller::handle(const wire::ros::JointState& message, const wire::WriterId& writer) {
  const JointCommands read = read_commands(message, [this](const std::string& name) {
    return find(name);
  });
  for (const std::string& problem : read.problems) {
    reports_.report(Severity::warning, "joint commands", problem);
  }
  std::set<std::uint32_t> benches;
  for (const JointCommand& command : read.commands) benches.insert(command.joint.bench);
  const std::int64_t stamp = nanoseconds_of(message.header().stamp());
  const std::string problem = stamp_problem(command_stamps_, writer, stamp, benches);
  if (!problem.empty()) {
    reports_.report(Severity::warning, "joint commands", problem + ": the command is ignored");
    return;
  }
  // Without a bench that has a time nobody knows whether the stamp is good.
  const bool is_judged = std::ranges::any_of(benches, [this](std::uint32_t bench) {
    return time_of(bench).has_value();
  });
  if (is_judged) command_stamps_.note(writer, stamp);
  for (const JointCommand& command : read.commands) motion_of(command.joint).command(command);
}

void Controller::handle(const wire::ros::Bool& message, const wire::WriterId& /*writer*/) {
  is_enabled_ = message.data();
  command_stamps_.clear();
  trajectory_stamps_.clear();
  reports_.report(Severity::info, "enable", is_enabled_ ? "true" : "false");
  if (!is_enabled_) waiting_.clear();
  for (auto& [number, bench] : benches_) bench.motion->want_enabled(is_enabled_, is_enabled_);
}

void Controller::check_writers() {
  std::size_t writers = 0;
  {
    const std::scoped_lock lock(mutex_);
    if (!writers_) return;
    writers = writers_();
  }
  if (writers == 0 && had_writers_) {
    for (auto& [number, bench] : benches_) {
      bench.motion->stop_free_joints("no node writes joint commands");
    }
  }
  had_writers_ = writers > 0;
}

void Controller::report_drops(Clock::time_point now) {
  wire::GuardCounts counts;
  {
    const std::scoped_lock lock(mutex_);
    if (!guard_counts_) return;
    counts = guard_counts_();
  }
  drops_.report(counts, now);
}

// ---- trajectories ----------------------------------------------------------------------------

void Controller::refuse_trajectory(const std::string& problem) {
  reports_.report(Severity::warning, "joint trajectory", "refused: " + problem);
}

std::string Controller::trajectory_problem(const Trajectory& trajectory,
                                           const wire::WriterId& writer) const {
  std::set<std::uint32_t> benches;
  for (const JointPlace& joint : trajectory.joints) benches.insert(joint.bench);
  const std::string stamp = stamp_problem(trajectory_stamps_, writer, trajectory.start, benches);
  if (!stamp.empty()) return stamp;
  for (std::size_t i = 0; i < trajectory.joints.size(); ++i) {
    const JointPlace& joint = trajectory.joints[i];
    const std::string problem = benches_.at(joint.bench).motion->trajectory_obstacle(joint.place);
    if (!problem.empty()) return "joint " + trajectory.names[i] + " " + problem;
  }
  return {};
}

void Controller::handle(const wire::ros::JointTrajectory& message, const wire::WriterId& writer) {
  std::string problem;
  auto trajectory = read_trajectory(
      message,
      [this](const std::string& name) {
        return find(name);
      },
      problem);
  if (trajectory) problem = trajectory_problem(*trajectory, writer);
  if (!problem.empty()) {
    refuse_trajectory(problem);
    return;
  }
  trajectory_stamps_.note(writer, trajectory->start);
  Waiting waiting{.trajectory = std::move(*trajectory), .limits = {}};
  for (const JointPlace& joint : waiting.trajectory.joints) {
    if (waiting.limits.contains(joint.bench)) continue;
    waiting.limits[joint.bench] = benches_.at(joint.bench).link->request_limits();
  }
  waiting_.clear();  // a new trajectory takes the place of one that has not started
  waiting_.push_back(std::move(waiting));
}

bool Controller::has_limits(const Waiting& waiting) const {
  return std::ranges::all_of(waiting.limits, [this](const auto& entry) {
    const auto bench = benches_.find(entry.first);
    return bench == benches_.end() || bench->second.link->limits_read() >= entry.second;
  });
}

void Controller::start_waiting() {
  std::erase_if(waiting_, [this](Waiting& waiting) {
    return has_limits(waiting) && try_start(waiting);
  });
}

/// @return whether it has been started or refused.
bool Controller::try_start(Waiting& waiting) {
  const Trajectory& trajectory = waiting.trajectory;
  for (std::size_t i = 0; i < trajectory.joints.size(); ++i) {
    const auto known = find(trajectory.names[i]);
    const std::string problem =
        known ? motion_of(known->place).trajectory_obstacle(known->place.place)
              : "is no longer present";
    if (problem.empty()) continue;
    refuse_trajectory("joint " + trajectory.names[i] + " " + problem);
    return true;
  }
  // One that starts later is checked at once as well, from the present positions.
  Start start = prepare(trajectory);
  if (start.waits && waiting.is_checked) return false;
  if (!start.problem.empty()) {
    refuse_trajectory(start.problem);
    return true;
  }
  waiting.is_checked = true;
  if (start.waits) return false;
  begin(trajectory, start);
  return true;
}

/// @param passed [s] of the trajectory that are over in the tick of its begin, by bench
void Controller::find_begins(const Trajectory& trajectory, Start& start,
                             std::map<std::uint32_t, double>& passed) {
  for (const JointPlace& joint : trajectory.joints) {
    if (start.begins.contains(joint.bench)) continue;
    const Bench& bench = benches_.at(joint.bench);
    std::uint64_t begin = bench.motion->begin_tick();
    if (trajectory.start != 0) {
      const std::int64_t early = trajectory.start - stamp_of(*bench.info, begin);
      const double ticks = static_cast<double>(early) * kNanosecond / bench.link->period();
      const auto whole = static_cast<std::uint64_t>(std::max(0.0, std::round(ticks)));
      begin = bench.motion->begin_tick(begin + whole);
    }
    start.begins[joint.bench] = begin;
    passed[joint.bench] = 0.0;
    if (trajectory.start == 0) continue;
    const std::int64_t stamp = stamp_of(*bench.info, begin);
    const double late = static_cast<double>(stamp - trajectory.start) * kNanosecond;
    // A difference below half a tick is rounding.
    if (late < -0.5 * bench.link->period()) start.waits = true;
    passed[joint.bench] = std::max(0.0, late);
  }
}

Controller::Start Controller::prepare(const Trajectory& trajectory) {
  Start start;
  std::map<std::uint32_t, double> passed;
  find_begins(trajectory, start, passed);
  start.paths.resize(trajectory.joints.size());
  for (std::size_t i = 0; i < trajectory.joints.size() && start.problem.empty(); ++i) {
    add_path(trajectory, i, start.waits ? 0.0 : passed[trajectory.joints[i].bench], start);
  }
  const bool is_empty = std::ranges::none_of(start.paths, [](const auto& path) {
    return path != nullptr;
  });
  if (start.problem.empty() && is_empty) start.problem = "all its points are in the past";
  return start;
}

void Controller::add_path(const Trajectory& trajectory, std::size_t joint, double passed,
                          Start& start) {
  const JointPlace& place = trajectory.joints[joint];
  BenchMotion& motion = motion_of(place);
  const Joint& known = motion.link().joints()[place.place];
  const JointMotion now = motion.motion(place.place);
  const double shortest = 0.5 * motion.link().period();
  std::vector<PathPoint> points;
  points.reserve(trajectory.points.size());
  for (const TrajectoryPoint& point : trajectory.points) {
    PathPoint path_point{.time = point.time - passed, .position = point.positions[joint]};
    if (!point.velocities.empty()) path_point.velocity = point.velocities[joint];
    if (!point.accelerations.empty()) path_point.acceleration = point.accelerations[joint];
    const bool is_start = path_point.time < shortest;
    const double gap = std::abs(path_point.position - now.position);
    if (is_start && point.time < shortest && !start.waits && gap > settings_.start_tolerance) {
      start.problem = "joint " + known.name + " is at " + text_of(now.position) +
                      ", its point at the start is " + text_of(path_point.position) + " " +
                      known.unit_name() + ": more than the start_tolerance of " +
                      text_of(settings_.start_tolerance) + " away";
      return;
    }
    if (!is_start) points.push_back(path_point);
  }
  if (points.empty()) return;
  auto path = std::make_shared<const JointPath>(now, points);
  const auto limits = motion.link().limits();
  const auto broken = limits ? path->check((*limits)[place.place], known.unit_name())
                             : std::optional<std::string>("its limits are not known");
  if (broken) {
    start.problem = "joint " + known.name + ": " + *broken;
    return;
  }
  start.paths[joint] = std::move(path);
}

void Controller::begin(const Trajectory& trajectory, const Start& start) {
  const std::uint64_t number = ++last_trajectory_;
  const std::string text = "number " + std::to_string(number) + " of " + joined(trajectory.names) +
                           ", " + std::to_string(trajectory.points.size()) + " points";
  std::set<std::uint64_t> replaced;
  for (const auto& known : trajectories_) {
    const std::uint64_t old = known.first;
    const bool is_replaced = std::ranges::any_of(trajectory.joints, [&](const JointPlace& joint) {
      return motion_of(joint).trajectory_of(joint.place) == old;
    });
    if (is_replaced) replaced.insert(old);
  }
  for (std::size_t i = 0; i < trajectory.joints.size(); ++i) {
    if (start.paths[i] == nullptr) continue;
    const JointPlace& joint = trajectory.joints[i];
    motion_of(joint).follow(joint.place, start.paths[i], start.begins.at(joint.bench), number);
  }
  // Joints of a replaced trajectory that this one does not move come to rest.
  for (const std::uint64_t old : replaced) {
    for (auto& [bench_number, bench] : benches_) bench.motion->brake(old);
    trajectories_.erase(old);
  }
  trajectories_[number] = text;
  reports_.report(Severity::info, "joint trajectory", text + ": starts");
}

void Controller::break_off(const std::vector<BrokenTrajectory>& broken) {
  for (const BrokenTrajectory& one : broken) {
    const auto known = trajectories_.find(one.number);
    if (known == trajectories_.end()) continue;
    reports_.report(Severity::error, "joint trajectory",
                    known->second + ": stopped, " + one.reason);
    trajectories_.erase(known);
    for (auto& [number, bench] : benches_) bench.motion->brake(one.number);
  }
}

void Controller::forget_trajectories() {
  std::erase_if(trajectories_, [this](const auto& trajectory) {
    const bool is_under_way = std::ranges::any_of(benches_, [&](const auto& entry) {
      return entry.second.motion->follows(trajectory.first);
    });
    if (!is_under_way) {
      reports_.report(Severity::info, "joint trajectory", trajectory.second + ": set-points sent");
    }
    return !is_under_way;
  });
}

void Controller::publish(bool is_urgent) {
  Board::Views views;
  for (const auto& [number, bench] : benches_) {
    views.emplace(number, BenchView{.info = bench.info,
                                    .joints = bench.joints,
                                    .state = bench.motion->state(),
                                    .limits = bench.link->limits(),
                                    .duties = bench.motion->duties(),
                                    .is_enabled = bench.motion->wants_enabled(),
                                    .session = session_.id()});
  }
  for (const auto& [number, left_out] : left_out_) {
    views.emplace(number, BenchView{.info = left_out.info,
                                    .joints = std::make_shared<const std::vector<Joint>>(),
                                    .session = session_.id(),
                                    .problem = left_out.reason});
  }
  board_.put(std::move(views), is_urgent);
}

}  // namespace vdrive::ros2
