// SPDX-License-Identifier: Apache-2.0
#include "churn/roles.hpp"

#include <array>

namespace vdrive::churn {
namespace {

using Clock = std::chrono::steady_clock;

/// Prints the state left by the previous visitor: position [UU] and stamp.
bool print_found(const client::Axis& axis) {
  const std::array objects{ObjectAddress{0x6064, 0}, kStampObject};
  const auto found = axis.read(objects);
  if (!found) {
    print_failure("read", found.outcome());
    return false;
  }
  print_line({{"found", found->objects[0].value}, {"stamp", found->objects[1].value}});
  return true;
}

/// Prints a line before and after each command, so that the killer of this program knows which one
/// was in progress.
bool command(client::Axis& axis, std::int64_t stamp) {
  print_line({{"start", "move"}});
  if (const auto moved = axis.move_by(kStep, quick(client::Until::in_force)); !moved) {
    print_failure("move_by", moved);
    return false;
  }
  print_line({{"done", "move"}});
  print_line({{"start", "stamp"}, {"stamp", stamp}});
  if (const auto written = axis.write(kStampObject, stamp); !written) {
    print_failure("write", written.outcome());
    return false;
  }
  print_line({{"done", "stamp"}, {"stamp", stamp}});
  const auto read_back = axis.read(kStampObject);
  if (!read_back) print_failure("read", read_back.outcome());
  if (read_back) print_line({{"read", *read_back}, {"written", stamp}});
  return static_cast<bool>(read_back);
}

bool stay(client::Axis& axis, const Visit& plan) {
  if (const auto acquired = axis.acquire(); !acquired) {
    print_failure("acquire", acquired);
    return false;
  }
  if (!print_found(axis)) return false;
  const auto base = prepare(axis);
  if (!base) {
    print_failure("prepare", base.outcome());
    return false;
  }
  print_line({{"base", *base}});
  std::int64_t stamp = plan.stamp;
  for (const auto end = Clock::now() + plan.duration; Clock::now() < end;) {
    if (!command(axis, ++stamp)) return false;
  }
  const auto demand = resting_demand(axis);
  if (!demand) {
    print_failure("rest", demand.outcome());
    return false;
  }
  print_line({{"demand", *demand}});
  return true;
}

}  // namespace

int visit(const Setting& setting, const Visit& plan) {
  client::Session session(setting.network);
  auto axis = session.axis(std::to_string(setting.bench) + "." + std::to_string(plan.axis));
  if (!axis) {
    print_failure("join", axis.outcome());
    return 1;
  }
  print_line({{"joined", plan.axis}});
  if (!stay(*axis, plan)) return 1;
  // The library waits for this answer only briefly. Without it, the axis may stay owned until the
  // watchdog notices.
  const auto released = session.release();
  print_line({{released ? "left" : "unreleased", plan.axis}});
  return 0;
}

}  // namespace vdrive::churn
