// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_finder.hpp"

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;

constexpr std::string_view kEveryAxis = "*";
constexpr std::string_view kEveryAxisOfBench = ".*";

/// @return the message with each axis number replaced by `both`.
std::string with_name(std::string message, const std::string& number, const std::string& both) {
  for (std::size_t at = message.find(number); at != std::string::npos;
       at = message.find(number, at + both.size())) {
    const std::size_t end = at + number.size();
    const bool goes_on = end < message.size() && message[end] >= '0' && message[end] <= '9';
    if (!goes_on) message.replace(at, number.size(), both);
  }
  return message;
}

/// @return the next step when another session is in the way.
std::string next_step_after(const Outcome& outcome) {
  if (outcome.owner() == nullptr) return {};
  // The axis was taken during a command.
  if (outcome.code() != wire_code(AbortCode::refused_local_control)) {
    return "; --take-over takes it back";
  }
  // Snapshots concern all axes of a bench, and their commands have no such option.
  const bool can_take_over = !outcome.message().starts_with("snapshot ");
  return can_take_over ? "; --take-over takes it, or end that program" : "; end that program first";
}

}  // namespace

client::Result<client::Axis> AxisFinder::axis(const std::string& name) {
  const auto known = axes_.find(name);
  if (known != axes_.end()) return known->second;
  auto found = session_.axis(name);
  if (!found) return found;
  axes_.emplace(name, *found);
  if (name != to_string(found->id())) typed_names_[found->id()] = name;
  benches_.insert(found->id().bench);
  return found;
}

client::Result<client::Axis> AxisFinder::axis_to_command(const std::string& name, bool take_over) {
  auto axis = this->axis(name);
  if (!axis || !take_over) return axis;
  if (Outcome taken = axis->take_over(); !taken) return taken;
  return axis;
}

client::Result<std::vector<client::Axis>> AxisFinder::axes(const std::vector<std::string>& names) {
  std::vector<client::Axis> axes;
  for (const std::string& name : names) {
    auto some = axes_named(name);
    if (!some) return some;
    for (client::Axis& axis : *some) {
      const bool is_twice = std::ranges::any_of(axes, [&axis](const client::Axis& other) {
        return other.id() == axis.id();
      });
      if (!is_twice) axes.push_back(std::move(axis));
    }
  }
  return axes;
}

client::Result<std::vector<client::Axis>> AxisFinder::axes_named(const std::string& name) {
  if (!name.ends_with(kEveryAxis)) {
    const auto axis = this->axis(name);
    if (!axis) return axis.outcome();
    return std::vector{*axis};
  }
  if (name == kEveryAxis) return axes_of_all_benches();
  const std::string_view text = name;
  const auto bench =
      name.ends_with(kEveryAxisOfBench)
          ? parse_digits<std::uint32_t>(text.substr(0, text.size() - kEveryAxisOfBench.size()))
          : std::nullopt;
  if (!bench) {
    return Outcome::not_found("no axis is named " + in_quotes(name) +
                              ": write for example '7.*' for all axes of bench 7, or '*'");
  }
  return axes_of_bench(*bench);
}

client::Result<std::vector<client::Axis>> AxisFinder::axes_of_bench(std::uint32_t bench) {
  auto axes = session_.axes(bench);
  if (axes) benches_.insert(bench);
  return axes;
}

client::Result<std::vector<client::Axis>> AxisFinder::axes_of_all_benches() {
  const auto benches = session_.find_benches();
  if (benches.empty()) return session_.no_bench_found();
  std::vector<client::Axis> all;
  for (const client::BenchInfo& bench : benches) {
    auto axes = axes_of_bench(bench.number);
    if (!axes) return axes;
    std::ranges::move(*axes, std::back_inserter(all));
  }
  return all;
}

std::vector<client::Axis> AxisFinder::known() const {
  std::map<client::AxisId, client::Axis> known;
  for (const auto& [name, axis] : axes_) known.emplace(axis.id(), axis);
  std::vector<client::Axis> axes;
  axes.reserve(known.size());
  for (const auto& [id, axis] : known) axes.push_back(axis);
  return axes;
}

std::string AxisFinder::label_of(const client::AxisId& axis) const {
  const auto typed = typed_names_.find(axis);
  return typed == typed_names_.end() ? to_string(axis) : escaped(typed->second);
}

Outcome AxisFinder::named(const Outcome& outcome) const {
  std::string message = outcome.message();
  for (const auto& [id, name] : typed_names_) {
    message = with_name(std::move(message), "axis " + to_string(id),
                        "axis " + escaped(name) + " (" + to_string(id) + ")");
  }
  return outcome.with_message(message + next_step_after(outcome));
}

std::int64_t AxisFinder::user_units(const client::Axis& axis, const Quantity& quantity) const {
  return user_units_of(quantity, axis.unit(), label_of(axis.id()));
}

std::optional<std::uint32_t> AxisFinder::limit(const client::Axis& axis,
                                               const std::optional<Quantity>& quantity) const {
  if (!quantity) return std::nullopt;
  return static_cast<std::uint32_t>(user_units(axis, *quantity));
}

Expectation AxisFinder::in_user_units(const client::Axis& axis, Expectation expectation) const {
  expectation.unit = axis.unit();
  if (expectation.quantity) {
    expectation.value = user_units(axis, *std::exchange(expectation.quantity, {}));
  }
  if (expectation.quantity_of_tolerance) {
    const Quantity tolerance = *std::exchange(expectation.quantity_of_tolerance, {});
    expectation.tolerance = static_cast<std::uint64_t>(user_units(axis, tolerance));
  }
  return expectation;
}

client::Result<client::BenchInfo> find_bench(client::Session& session,
                                             std::optional<std::uint32_t> number,
                                             std::string_view how_to_name) {
  auto bench = session.find_bench(number);
  if (bench || number || session.find_benches().size() < 2) return bench;
  return Outcome::not_found(bench.outcome().message() + "; " + std::string(how_to_name));
}

client::Result<std::vector<client::BenchInfo>> benches_to_show(
    client::Session& session, std::optional<std::uint32_t> number) {
  if (number) {
    auto bench = session.find_bench(number);
    if (!bench) return bench.outcome();
    return std::vector{std::move(*bench)};
  }
  auto benches = session.find_benches();
  if (benches.empty()) return session.no_bench_found();
  return benches;
}

}  // namespace vdrive::tool
