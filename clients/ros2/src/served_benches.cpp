// SPDX-License-Identifier: Apache-2.0
#include "served_benches.hpp"

#include "ros_time.hpp"
#include "topic_names.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::ros2 {
namespace {

using bridge::Severity;

// A new bench is served without noticeable delay, and the search costs a cycle little.
constexpr std::chrono::milliseconds kFindPeriod{200};

}  // namespace

ServedBenches::ServedBenches(std::uint64_t session, const Settings& settings,
                             bridge::Reports& reports, BenchAccess& access)
    : session_(session),
      settings_(settings),
      reports_(reports),
      access_(access),
      is_enabled_(settings.is_enabled),
      roster_(*this, settings.benches) {}

void ServedBenches::find(Clock::time_point now) {
  if (now < find_due_) return;
  find_due_ = now + kFindPeriod;
  (void)roster_.take(access_.present_benches(), now);
  for (const bridge::BenchRecord& record : roster_.all()) {
    const client::BenchInfo& info = record.info;
    // The rate 0 of a paused bench is left out: the lead in ticks must be right when time
    // continues.
    const bool has_rate = info.clock_mode == client::ClockMode::realtime && info.rate > 0.0;
    if (record.is_served && has_rate) benches_.at(info.number).bench->set_rate(info.rate);
  }
}

/// The plans of a bench end with its run.
bool ServedBenches::continues(const client::BenchInfo& known,
                              const client::BenchInfo& found) const {
  return known.incarnation == found.incarnation && bridge::are_same_axes(known.axes, found.axes);
}

void ServedBenches::remove(std::uint32_t number, bool is_replaced) {
  const auto known = benches_.find(number);
  ensure(known != benches_.end(), "a bench that was added is served");
  const std::string name = known->second.bench->label();
  directory_.remove(number);
  // Before the bench is erased: its trajectories may include joints of other benches, which must
  // brake.
  if (is_replaced) access_.end_run(*known->second.motion);
  benches_.erase(known);
  if (is_replaced) reports_.report(Severity::warning, name, "was restarted");
}

void ServedBenches::leave_out(const client::BenchInfo& info, const std::string& reason) {
  reports_.report(Severity::error, "bench " + std::to_string(info.number), reason);
  left_out_[info.number] = {
      .bench = std::make_shared<const Bench>(info, std::vector<ServedJoint>{}),
      .session = session_,
      .problem = reason};
}

std::optional<std::string> ServedBenches::add(const client::BenchInfo& info) {
  std::vector<ServedJoint> joints = joints_of(info, settings_);
  if (auto clash = directory_.add(info.number, joints)) return clash;
  ServedBench served;
  served.bench = std::make_shared<Bench>(info, std::move(joints));
  served.link = access_.connect(*served.bench);
  served.motion =
      std::make_unique<BenchMotion>(session_, *served.bench, reports_, settings_.command_timeout,
                                    [this, number = info.number](const auto& frames) {
                                      return access_.send_set_points(number, frames);
                                    });
  if (settings_.is_enabled && is_enabled_) served.motion->power().want_enabled(true, false);
  reports_.report(Severity::info, served.bench->label(),
                  "found, " + std::to_string(info.axes.size()) + " joints");
  benches_.emplace(info.number, std::move(served));
  return std::nullopt;
}

void ServedBenches::enable(bool wanted) {
  is_enabled_ = wanted;
  for (auto& [number, bench] : benches_) bench.motion->power().want_enabled(wanted, wanted);
}

BenchMotion& ServedBenches::motion_of(std::uint32_t bench) const {
  const auto known = benches_.find(bench);
  ensure(known != benches_.end(), "the directory names joints of benches that are served");
  return *known->second.motion;
}

std::optional<std::int64_t> ServedBenches::time_of(std::uint32_t bench) const {
  const auto known = benches_.find(bench);
  if (known == benches_.end() || !known->second.motion->state()) return std::nullopt;
  return stamp_of(known->second.bench->info(), known->second.motion->state()->tick);
}

bool ServedBenches::any_in_lockstep() const {
  return std::ranges::any_of(benches_, [](const auto& entry) {
    return entry.second.bench->info().clock_mode == client::ClockMode::lockstep;
  });
}

Board::Views ServedBenches::views() const {
  Board::Views views;
  for (const auto& [number, bench] : benches_) {
    views.emplace(number, BenchView{.bench = bench.bench,
                                    .state = bench.motion->state(),
                                    .limits = bench.bench->seen().limits,
                                    .names = bench.bench->seen().names,
                                    .tasks = bench.motion->tasks(),
                                    .is_enabled = bench.motion->power().wants_enabled(),
                                    .session = session_});
  }
  for (const auto& [number, reason] : roster_.left_out()) {
    views.emplace(number, left_out_.at(number));
  }
  return views;
}

}  // namespace vdrive::ros2
