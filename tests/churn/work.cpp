// SPDX-License-Identifier: Apache-2.0
// Programs that keep running while wires are killed. None of them restarts: a failed call is
// printed, and the next one is made.
#include "churn/roles.hpp"
#include "vdrive/client/axis_group.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <thread>

namespace vdrive::churn {
namespace {

using namespace std::chrono_literals;

/// A long move [UU]: 0.3 s, so that most kills happen while a call waits.
constexpr std::int32_t kLongMove = 4096;

std::string name_of(const Setting& setting, std::uint16_t axis) {
  return std::to_string(setting.bench) + "." + std::to_string(axis);
}

/// Counts commands that must act exactly once if acknowledged, and at most once otherwise.
struct Count {
  std::uint64_t acknowledged = 0;
  std::uint64_t uncertain = 0;

  /// @return whether the call succeeded.
  bool take(const char* call, const client::Outcome& outcome) {
    ++(outcome ? acknowledged : uncertain);
    if (!outcome) print_failure(call, outcome);
    return static_cast<bool>(outcome);
  }
};

/// Repeats a call until it succeeds or the role is stopped; each failure is printed.
template <typename Call>
auto insist(const char* name, Call call) {
  auto result = call();
  while (!result && !is_stop_requested()) {
    print_failure(name, result.outcome());
    result = call();
  }
  return result;
}

// ---- motion

/// An axis ready for relative moves from `base` [UU].
struct Prepared {
  client::Axis axis;
  std::int32_t base = 0;
};

std::optional<Prepared> find_and_prepare(client::Session& session, const std::string& name) {
  auto axis = insist("find", [&] {
    return session.axis(name);
  });
  if (!axis) return std::nullopt;
  const auto base = insist("prepare", [&] {
    return prepare(*axis);
  });
  if (!base) return std::nullopt;
  return Prepared{*axis, *base};
}

/// Moves one axis by equal distances and stamps it, waiting for the end of long moves.
void move_axis(Prepared prepared, bool is_long) {
  client::Axis* const axis = &prepared.axis;
  const std::int32_t distance = is_long ? kLongMove : kStep;
  Count moves;
  Count stamps;
  std::int64_t stamp = 0;
  const auto until = is_long ? client::Until::done : client::Until::in_force;
  while (!is_stop_requested()) {
    if (!moves.take("move_by", axis->move_by(distance, quick(until)))) {
      // A lost axis is acquired again; its position is judged at the end.
      static_cast<void>(axis->reset_fault());
      static_cast<void>(axis->enable());
    }
    stamps.take("write", axis->write(kStampObject, ++stamp).outcome());
  }
  const auto demand = resting_demand(*axis);
  const auto read_back = axis->read(kStampObject);
  if (!demand) print_failure("rest", demand.outcome());
  if (!read_back) print_failure("read", read_back.outcome());
  if (!demand || !read_back) return;
  print_line({{"axis", to_string(axis->id())},
              {"distance", distance},
              {"acknowledged", moves.acknowledged},
              {"uncertain", moves.uncertain},
              {"moved", std::int64_t{*demand} - prepared.base},
              {"stamp", *read_back},
              {"stamps", stamps.acknowledged},
              {"uncertain_stamps", stamps.uncertain},
              {"last_stamp", stamp}});
}

// ---- stream

constexpr double kAmplitude = 2048.0;  // [UU]
constexpr std::uint64_t kMostInterruptions = 100'000;
constexpr std::uint64_t kPeriod = 2'000;  // [ticks]

Eigen::VectorXd wave(const Eigen::VectorXd& base, std::uint64_t phase) {
  // 1 - cos begins and ends at rest.
  const double angle = 2.0 * std::numbers::pi * static_cast<double>(phase % kPeriod) / kPeriod;
  return base.array() + kAmplitude * (1.0 - std::cos(angle));
}

/// Streams until a position is refused or the role is stopped.
/// @return the number of accepted positions; the last one is in `last`.
std::uint64_t stream_once(client::AxisGroup& group, const client::StreamOptions& options,
                          std::optional<Eigen::VectorXd>& last) {
  if (const auto started = group.start_streaming(options); !started) {
    print_failure("start_streaming", started);
    return 0;
  }
  const auto status = group.status();
  if (!status) {
    print_failure("status", status.outcome());
    return 0;
  }
  const Eigen::VectorXd base = status->demand();
  std::uint64_t phase = 0;
  // Ends at rest, after an integer number of waves.
  do {
    Eigen::VectorXd positions = wave(base, phase);
    const auto seen = group.stream(positions);
    if (!seen) {
      print_failure("stream", seen.outcome());
      last.reset();
      return phase;
    }
    last = std::move(positions);
    ++phase;
  } while (!is_stop_requested() || phase % kPeriod != 0);
  return phase;
}

/// @return the largest difference between 6062h and the last streamed position of any axis [UU],
///         once the demands are at rest.
client::Result<double> distance_to(client::Session& session, const client::AxisGroup& group,
                                   const Eigen::VectorXd& target) {
  double largest = 0.0;
  Eigen::Index place = 0;
  for (const client::AxisId& id : group.axes()) {
    const auto axis = session.axis(to_string(id));
    if (!axis) return axis.outcome();
    // The last positions take effect in their ticks, up to the lead later.
    const auto wanted = static_cast<std::int32_t>(std::lround(target[place++]));
    const auto seen = axis->wait_until(
        [wanted](const client::AxisSnapshot& now) {
          return now.status.position_demand_value == wanted;
        },
        5s);
    if (seen) continue;
    const auto now = axis->status();
    if (!now) return now.outcome();
    largest = std::max(largest,
                       std::abs(static_cast<double>(wanted) - now->status.position_demand_value));
  }
  return largest;
}

}  // namespace

int motion(const Setting& setting, AxisRange range) {
  client::Session session(setting.network);
  {
    // One after the other, because each acquisition renews the session's epoch.
    std::vector<Prepared> axes;
    for (std::uint32_t axis = range.first; axis <= range.last; ++axis) {
      auto prepared = find_and_prepare(session, name_of(setting, static_cast<std::uint16_t>(axis)));
      if (!prepared) return 1;
      axes.push_back(std::move(*prepared));
    }
    std::vector<std::jthread> threads;
    threads.reserve(axes.size());
    for (const Prepared& prepared : axes) {
      threads.emplace_back(move_axis, prepared, prepared.axis.id().axis % 2 == 0);
    }
  }
  print_line({{"ended", "motion"}});
  return 0;
}

int stream(const Setting& setting, AxisRange range, std::chrono::milliseconds lead) {
  client::Session session(setting.network);
  std::vector<std::string> names;
  for (std::uint32_t axis = range.first; axis <= range.last; ++axis) {
    names.push_back(name_of(setting, static_cast<std::uint16_t>(axis)));
  }
  auto group = client::AxisGroup::create(session, names);
  if (!group) {
    print_failure("group", group.outcome());
    return 1;
  }
  std::uint64_t positions = 0;
  std::uint64_t interruptions = 0;
  std::optional<Eigen::VectorXd> last;
  do {
    if (positions != 0) ++interruptions;
    if (const auto enabled = group->enable_all(); !enabled) print_failure("enable_all", enabled);
    positions += stream_once(*group, {.lead = lead}, last);
    if (!last) static_cast<void>(group->stop_streaming());
    // A call interrupted at the very end is repeated, because the final position is judged.
  } while (!is_stop_requested() || (!last && interruptions < kMostInterruptions));
  Json result{{"positions", positions}, {"interruptions", interruptions}};
  if (last) {
    const auto off = distance_to(session, *group, *last);
    if (!off) print_failure("end", off.outcome());
    if (off) result["off"] = *off;
  }
  print_line(std::move(result));
  return 0;
}

int group(const Setting& setting, const std::vector<std::string>& axes) {
  client::Session session(setting.network);
  auto group = insist("group", [&] {
    return client::AxisGroup::create(session, axes);
  });
  if (!group) return 1;
  for (auto ready = group->enable_all(); !ready && !is_stop_requested();
       ready = group->enable_all()) {
    print_failure("enable_all", ready);
  }
  const auto status = group->status();
  if (!status) return 1;
  const Eigen::VectorXd base = status->demand();
  Eigen::VectorXd way(base.size());
  for (Eigen::Index place = 0; place < way.size(); ++place) {
    way[place] = kLongMove * static_cast<double>(place + 1) / 4.0;
  }
  // A frame that is late at only one bench is refused there, and the call reports it. Since the
  // targets are absolute, repeating the call brings the axes together again. The last call is
  // repeated, too, because the final position is judged.
  Count moves;
  bool is_taken = false;
  do {
    const double ways = static_cast<double>(moves.acknowledged + 1);
    is_taken = moves.take("move_together", group->move_together(base + ways * way));
    if (is_taken) continue;
    static_cast<void>(group->reset_all());
    static_cast<void>(group->enable_all());
  } while (!is_stop_requested() || (!is_taken && moves.uncertain < kMostInterruptions));
  const auto end = group->status();
  if (!end) {
    print_failure("status", end.outcome());
    return 1;
  }
  // After n moves, all axes of a group have moved by n distances.
  const Eigen::VectorXd moved = (end->demand() - base).cwiseQuotient(way);
  print_line({{"acknowledged", moves.acknowledged},
              {"refused", moves.uncertain},
              {"least", moved.minCoeff()},
              {"most", moved.maxCoeff()}});
  return 0;
}

int store(const Setting& setting, AxisRange range) {
  client::Session session(setting.network);
  auto axis = session.axis(name_of(setting, range.first));
  if (!axis) {
    print_failure("find", axis.outcome());
    return 1;
  }
  Count stores;
  std::int64_t stamp = 0;
  std::int64_t durable = 0;
  while (!is_stop_requested()) {
    if (const auto written = axis->write(kStampObject, ++stamp); !written) {
      print_failure("write", written.outcome());
    }
    if (stores.take("store", axis->store())) durable = stamp;
  }
  print_line({{"acknowledged", stores.acknowledged},
              {"uncertain", stores.uncertain},
              {"durable", durable},
              {"last_stamp", stamp}});
  return 0;
}

int step(const Setting& setting) {
  client::Session session(setting.network);
  const auto begin = insist("step", [&] {
    return session.step(setting.bench, 0);
  });
  if (!begin) return 1;
  Count steps;
  std::uint64_t wrong = 0;
  std::uint64_t reached = *begin;
  Pauses pauses;
  while (!is_stop_requested()) {
    const auto tick = session.step(setting.bench, 1);
    if (pauses.note()) print_line({{"seen", steps.acknowledged}});
    if (!steps.take("step", tick.outcome())) continue;
    if (steps.uncertain == 0 && *tick != reached + 1) ++wrong;
    reached = *tick;
  }
  const auto end = session.step(setting.bench, 0);
  if (!end) {
    print_failure("step", end.outcome());
    return 1;
  }
  print_line({{"acknowledged", steps.acknowledged},
              {"uncertain", steps.uncertain},
              {"ticks", *end - *begin},
              {"wrong", wrong}});
  return 0;
}

}  // namespace vdrive::churn
