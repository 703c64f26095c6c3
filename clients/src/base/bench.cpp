// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/bench.hpp"

#include "vdrive/client/disturbance.hpp"
#include "vdrive/client/session_name.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive_messages_description.hpp"

namespace vdrive::client {

std::string to_string(const AxisId& id) {
  return std::to_string(id.bench) + "." + std::to_string(id.axis);
}

std::string to_string(const SessionName& name) {
  std::string where;
  if (name.process != 0) where = "process " + std::to_string(name.process);
  if (!name.host.empty()) where += (where.empty() ? "on " : " on ") + name.host;
  const std::string program = name.program.empty() ? "an unknown program" : name.program;
  return where.empty() ? program : program + " (" + where + ")";
}

std::string owner_text(std::uint64_t session, const std::optional<SessionName>& name) {
  return to_string(name.value_or(SessionName{})) + ", session " + session_text(session);
}

std::string to_string(const AxisOwner& owner) {
  const std::string axis = owner.axis.axis == 0 ? "it" : "axis " + to_string(owner.axis);
  return axis + " is controlled by " + owner_text(owner.session, owner.name);
}

std::string text_of(const DisturbanceRow& row) {
  if (row.fault == ErrorCode::none) return "no fault: " + std::string(row.effect);
  return "fault " + hex(static_cast<std::uint64_t>(row.fault), 4).substr(2) + "h, " +
         std::string(vdrive::describe(row.fault)) + ": " + std::string(row.effect);
}

std::optional<AxisId> parse_axis_id(std::string_view text) noexcept {
  const std::size_t dot = text.find('.');
  if (dot == std::string_view::npos) return std::nullopt;
  const auto bench = parse_digits<std::uint32_t>(text.substr(0, dot));
  const auto axis = parse_digits<std::uint16_t>(text.substr(dot + 1));
  if (!bench || !axis) return std::nullopt;
  return AxisId{*bench, *axis};
}

std::vector<Figure> all_figures() {
  std::vector<Figure> figures;
  wire::for_each_figure<msg::BenchState>([&](const wire::MemberTraits& member) {
    figures.push_back({.name = member.name,
                       .unit = member.unit,
                       .help = member.help,
                       .is_counter = member.figure == wire::FigureKind::counter,
                       .is_headline = member.is_headline});
  });
  return figures;
}

std::uint64_t ticks_of(std::chrono::nanoseconds duration,
                       std::chrono::microseconds period) noexcept {
  const auto length = std::chrono::nanoseconds(period).count();
  if (duration.count() <= 0 || length <= 0) return 0;
  const auto whole = duration.count() / length;
  return static_cast<std::uint64_t>(whole) + (duration.count() % length != 0 ? 1U : 0U);
}

}  // namespace vdrive::client
