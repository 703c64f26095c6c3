// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "values/expectation.hpp"
#include "values/units.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// Finds the axes that commands name, each once, and knows what the user calls them.
class AxisFinder {
 public:
  explicit AxisFinder(client::Session& session) : session_(session) {}

  /// Its bench is one of benches() from now on.
  client::Result<client::Axis> axis(const std::string& name);

  /// The same, and takes control of it where that is wanted.
  client::Result<client::Axis> axis_to_command(const std::string& name, bool take_over);

  /// @param names 7.* is every axis of bench 7, * every axis of every bench
  /// @return the axes that the names stand for, each once.
  client::Result<std::vector<client::Axis>> axes(const std::vector<std::string>& names);

  client::Result<std::vector<client::Axis>> axes_of_bench(std::uint32_t bench);
  client::Result<std::vector<client::Axis>> axes_of_all_benches();

  /// A bench that commands are about without naming an axis of it.
  void add_bench(std::uint32_t bench) { benches_.insert(bench); }

  /// The benches of the axes that were found, and those that were added: `wait` lets time pass on
  /// them.
  [[nodiscard]] const std::set<std::uint32_t>& benches() const noexcept { return benches_; }

  /// @return the axes that were called one by one, each once.
  [[nodiscard]] std::vector<client::Axis> known() const;

  /// @return an axis as the user calls it.
  [[nodiscard]] std::string label_of(const client::AxisId& axis) const;

  /// The client's messages call an axis by its number.
  /// @return them with the name that was typed: "axis gantry_left (7.1)"; where another session
  ///         stands in the way, with what to do about it.
  [[nodiscard]] client::Outcome named(const client::Outcome& outcome) const;

  /// @return [UU] of this axis.
  /// @throws UsageError for a unit that the axis has not, and for a value that is out of range with
  ///         it.
  [[nodiscard]] std::int64_t user_units(const client::Axis& axis, const Quantity& quantity) const;

  /// The same of a speed or a ramp, where one was given.
  [[nodiscard]] std::optional<std::uint32_t> limit(const client::Axis& axis,
                                                   const std::optional<Quantity>& quantity) const;

  /// The same of what an object is expected to be.
  [[nodiscard]] Expectation in_user_units(const client::Axis& axis, Expectation expectation) const;

 private:
  client::Result<std::vector<client::Axis>> axes_named(const std::string& name);

  client::Session& session_;
  std::map<std::string, client::Axis> axes_;
  std::map<client::AxisId, std::string> typed_names_;  ///< of axes that were not called by number
  std::set<std::uint32_t> benches_;
};

/// @param number none = the only bench there is
/// @param how_to_name what to write where there are several benches
[[nodiscard]] client::Result<client::BenchInfo> find_bench(client::Session& session,
                                                           std::optional<std::uint32_t> number,
                                                           std::string_view how_to_name);

/// @return the bench of this number; all benches where it is none, at least one.
[[nodiscard]] client::Result<std::vector<client::BenchInfo>> benches_to_show(
    client::Session& session, std::optional<std::uint32_t> number);

}  // namespace vdrive::tool
