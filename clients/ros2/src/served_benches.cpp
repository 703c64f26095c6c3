// SPDX-License-Identifier: Apache-2.0
#include "served_benches.hpp"

#include "topic_names.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::ros2 {
namespace {

using bridge::Severity;

constexpr std::chrono::milliseconds kFindPeriod{200};

/// The plans of a bench end with its run.
bool is_same_run(const client::BenchInfo& known, const client::BenchInfo& found) {
  return known.incarnation == found.incarnation && bridge::are_same_axes(known.axes, found.axes);
}

}  // namespace

ServedBenches::ServedBenches(client::Session& session, const Settings& settings,
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
      known->second.link->set_rate(info.rate);
    }
  }
}

void ServedBenches::remove(std::uint32_t number, bool is_replaced) {
  const auto known = benches_.find(number);
  if (known == benches_.end()) return;
  const std::string name = known->second.link->name();
  directory_.remove(number);
  if (is_replaced) calls_.restarted(*known->second.motion);
  benches_.erase(known);
  if (is_replaced) reports_.report(Severity::warning, name, "was restarted");
}

void ServedBenches::leave_out(const client::BenchInfo& info, const std::string& reason) {
  LeftOut& left_out = left_out_[info.number];
  if (left_out.reason != reason || left_out.info->incarnation != info.incarnation) {
    reports_.report(Severity::error, "bench " + std::to_string(info.number), reason);
  }
  left_out = {.info = std::make_shared<const client::BenchInfo>(info), .reason = reason};
}

void ServedBenches::add(const client::BenchInfo& info) {
  std::vector<Joint> joints = joints_of(info, settings_);
  if (const auto clash = directory_.add(info.number, joints)) {
    leave_out(info, *clash);
    return;
  }
  left_out_.erase(info.number);
  ServedBench bench;
  bench.info = std::make_shared<const client::BenchInfo>(info);
  bench.joints = std::make_shared<const std::vector<Joint>>(joints);
  const bool is_urgent = info.clock_mode == client::ClockMode::lockstep;
  bench.link = std::make_unique<BenchLink>(
      session_, info, std::move(joints), reports_, is_urgent ? calls_.notify : [] {});
  bench.motion =
      std::make_unique<BenchMotion>(session_, *bench.link, reports_, settings_.command_timeout);
  if (settings_.is_enabled && is_enabled_) bench.motion->want_enabled(true, false);
  reports_.report(Severity::info, bench.link->name(),
                  "found, " + std::to_string(info.axes.size()) + " joints");
  benches_.emplace(info.number, std::move(bench));
}

void ServedBenches::enable(bool wanted) {
  is_enabled_ = wanted;
  for (auto& [number, bench] : benches_) bench.motion->want_enabled(wanted, wanted);
}

std::optional<KnownJoint> ServedBenches::find_joint(const std::string& name) const {
  const auto place = directory_.find(name);
  if (!place) return std::nullopt;
  return KnownJoint{.place = *place,
                    .interface = (*benches_.at(place->bench).joints)[place->place].interface};
}

std::optional<std::int64_t> ServedBenches::time_of(std::uint32_t bench) const {
  const auto known = benches_.find(bench);
  if (known == benches_.end() || !known->second.motion->state()) return std::nullopt;
  return stamp_of(*known->second.info, known->second.motion->state()->tick);
}

bool ServedBenches::any_in_lockstep() const {
  return std::ranges::any_of(benches_, [](const auto& entry) {
    return entry.second.info->clock_mode == client::ClockMode::lockstep;
  });
}

Board::Views ServedBenches::views() const {
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
  return views;
}

}  // namespace vdrive::ros2
