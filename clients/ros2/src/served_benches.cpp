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

// A bench that comes is served at once for a person, and the search costs a turn little.
constexpr std::chrono::milliseconds kFindPeriod{200};

/// The plans of a bench end with its run.
bool is_same_run(const client::BenchInfo& known, const client::BenchInfo& found) {
  return known.incarnation == found.incarnation && bridge::are_same_axes(known.axes, found.axes);
}

}  // namespace

ServedBenches::ServedBenches(std::uint64_t session, const Settings& settings,
                             bridge::Reports& reports, Calls calls)
    : session_(session),
      settings_(settings),
      reports_(reports),
      calls_(std::move(calls)),
      is_enabled_(settings.is_enabled),
      presence_({.continues = is_same_run, .wanted = settings.benches}) {}

void ServedBenches::find(Clock::time_point now) {
  if (now < find_due_) return;
  find_due_ = now + kFindPeriod;
  const std::vector<client::BenchInfo> present = calls_.present();
  const auto is_present = [&present](std::uint32_t number) {
    return std::ranges::count(present, number, &client::BenchInfo::number) > 0;
  };
  std::erase_if(left_out_, [&](const auto& entry) {
    return !is_present(entry.first);
  });
  using Kind = bridge::PresenceChange::Kind;
  for (const bridge::PresenceChange& change : presence_.take(present, now)) {
    if (change.kind == Kind::went || change.kind == Kind::replaced) {
      remove(change.bench, change.kind == Kind::replaced);
    }
  }
  // Also a bench that was left out: another one may have set its names free.
  for (const bridge::BenchRecord& record : presence_.all()) {
    const client::BenchInfo& info = record.info;
    const auto known = benches_.find(info.number);
    if (known == benches_.end()) {
      if (is_present(info.number)) add(info);
    } else if (info.clock_mode == client::ClockMode::realtime && info.rate > 0.0) {
      // Not that of a pause: the lead in ticks has to be right when time goes on.
      known->second.bench->set_rate(info.rate);
    }
  }
}

void ServedBenches::remove(std::uint32_t number, bool is_replaced) {
  const auto known = benches_.find(number);
  if (known == benches_.end()) return;
  const std::string name = known->second.bench->label();
  directory_.remove(number);
  // Before it is erased: other benches brake what they do for the same trajectory.
  if (is_replaced) calls_.restarted(*known->second.motion);
  benches_.erase(known);
  if (is_replaced) reports_.report(Severity::warning, name, "was restarted");
}

void ServedBenches::leave_out(const client::BenchInfo& info, const std::string& reason) {
  LeftOut& left_out = left_out_[info.number];
  if (left_out.reason != reason || left_out.bench->info().incarnation != info.incarnation) {
    reports_.report(Severity::error, "bench " + std::to_string(info.number), reason);
  }
  left_out = {.bench = std::make_shared<const Bench>(info, std::vector<ServedJoint>{}),
              .reason = reason};
}

void ServedBenches::add(const client::BenchInfo& info) {
  std::vector<ServedJoint> joints = joints_of(info, settings_);
  if (const auto clash = directory_.add(info.number, joints)) {
    leave_out(info, *clash);
    return;
  }
  left_out_.erase(info.number);
  ServedBench served;
  served.bench = std::make_shared<Bench>(info, std::move(joints));
  served.link = calls_.connect(*served.bench);
  served.motion =
      std::make_unique<BenchMotion>(session_, *served.bench, reports_, settings_.command_timeout,
                                    [this, number = info.number](const auto& frames) {
                                      return calls_.send(number, frames);
                                    });
  if (settings_.is_enabled && is_enabled_) served.motion->power().want_enabled(true, false);
  reports_.report(Severity::info, served.bench->label(),
                  "found, " + std::to_string(info.axes.size()) + " joints");
  benches_.emplace(info.number, std::move(served));
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
                                    .duties = bench.motion->duties(),
                                    .is_enabled = bench.motion->power().wants_enabled(),
                                    .session = session_});
  }
  for (const auto& [number, left_out] : left_out_) {
    views.emplace(
        number,
        BenchView{.bench = left_out.bench, .session = session_, .problem = left_out.reason});
  }
  return views;
}

}  // namespace vdrive::ros2
