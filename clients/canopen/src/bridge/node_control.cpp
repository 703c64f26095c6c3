// SPDX-License-Identifier: Apache-2.0
#include "bridge/node_control.hpp"

#include <utility>

namespace vdrive::canopen {
namespace {

bridge::ControlKeeper::Calls calls_of_keeper(client::Session& session,
                                             const std::vector<client::AxisId>& axes,
                                             std::string label, bridge::Reports& reports) {
  return {
      .acquire =
          [&session, &axes] {
            return session.acquire(axes);
          },
      .observe = [&session, &axes]() -> std::optional<client::Observation> {
        auto now = session.observe(axes);
        if (!now) return std::nullopt;
        return std::move(*now);
      },
      .report =
          [&reports, label = std::move(label)](bridge::Severity severity, const std::string& text) {
            reports.report(severity, label, text);
          },
      .name_of =
          [&session, bench = axes.front().bench](std::uint64_t other) {
            return client::owner_text(other, session.find_name(bench, other));
          },
      .remedy = "its nodes take it again when all of its axes are free",
      .fault_remedy = "bit 7 of 6040h resets them"};
}

}  // namespace

std::vector<client::AxisId> ids_of(const client::BenchInfo& info) {
  std::vector<client::AxisId> ids;
  ids.reserve(info.axes.size());
  for (const client::AxisInfo& axis : info.axes) ids.push_back(axis.id);
  return ids;
}

NodeControl::NodeControl(client::Session& session, std::vector<client::AxisId> axes,
                         std::string label, bridge::Reports& reports)
    : session_(session),
      axes_(std::move(axes)),
      keeper_(session.id(), calls_of_keeper(session, axes_, std::move(label), reports)) {
  keeper_.want(true);
}

std::optional<client::Observation> NodeControl::keep(std::span<const client::AxisSnapshot> axes) {
  auto held = keeper_.keep(axes, bridge::ControlKeeper::Clock::now());
  if (held) {
    // The state of a paused bench names no owner, and it was asked a moment ago.
    for (client::AxisSnapshot& axis : held->axes) {
      if (!axis.has_owner) axis.owner_session = session_.id();
    }
    return held;
  }
  // A master of a bus cannot ask for control: it comes back by itself, as at a real drive whose
  // local operator leaves.
  const bool are_free = !bridge::other_owner(axes, session_.id());
  if (are_free && !bridge::owns_all(axes, session_.id())) keeper_.want(true);
  return std::nullopt;
}

}  // namespace vdrive::canopen
