// SPDX-License-Identifier: Apache-2.0
// The axes that a command names: addresses, names, and * for many.
#include "execution/executor.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;

constexpr std::string_view kEveryAxis = "*";
constexpr std::string_view kEveryAxisOfBench = ".*";

}  // namespace

client::Result<std::vector<client::Axis>> Executor::axes(const std::vector<std::string>& names) {
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

client::Result<std::vector<client::Axis>> Executor::axes_named(const std::string& name) {
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

client::Result<std::vector<client::Axis>> Executor::axes_of_bench(std::uint32_t bench) {
  auto axes = session_.axes(bench);
  if (axes) benches_.insert(bench);
  return axes;
}

client::Result<std::vector<client::Axis>> Executor::axes_of_all_benches() {
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

}  // namespace vdrive::tool
