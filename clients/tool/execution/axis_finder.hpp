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

/// Finds the axes that commands name, each once, and remembers the names that the user has typed.
class AxisFinder {
 public:
  explicit AxisFinder(client::Session& session) : session_(session) {}

  /// Finds an axis, and adds its bench to benches().
  client::Result<client::Axis> axis(const std::string& name);

  /// As axis(), and takes control of the axis if `take_over`.
  client::Result<client::Axis> axis_to_command(const std::string& name, bool take_over);

  /// @param names 7.* is every axis of bench 7, * every axis of every bench
  /// @return the axes with these names, each once.
  client::Result<std::vector<client::Axis>> axes(const std::vector<std::string>& names);

  client::Result<std::vector<client::Axis>> axes_of_bench(std::uint32_t bench);
  client::Result<std::vector<client::Axis>> axes_of_all_benches();

  /// Adds a bench that a command refers to without naming an axis.
  void add_bench(std::uint32_t bench) { benches_.insert(bench); }

  /// The benches of the axes found, and those added: `wait` lets time pass on them.
  [[nodiscard]] const std::set<std::uint32_t>& benches() const noexcept { return benches_; }

  /// @return the axes named individually, each once.
  [[nodiscard]] std::vector<client::Axis> known() const;

  /// @return the name that the user has typed for an axis.
  [[nodiscard]] std::string label_of(const client::AxisId& axis) const;

  /// @return the outcome, with the name that the user has typed added to the axis number in its
  ///         message: "axis gantry_left (7.1)". If another session is in the way, the next step is
  ///         added too.
  [[nodiscard]] client::Outcome named(const client::Outcome& outcome) const;

  /// @return [UU] of this axis.
  /// @throws UsageError for a unit that the axis does not have, and for a value that is out of
  ///         range after conversion from its unit.
  [[nodiscard]] std::int64_t user_units(const client::Axis& axis, const Quantity& quantity) const;

  /// As user_units(), for a speed or a ramp if one was given.
  [[nodiscard]] std::optional<std::uint32_t> limit(const client::Axis& axis,
                                                   const std::optional<Quantity>& quantity) const;

  /// As user_units(), for the values of an expectation.
  [[nodiscard]] Expectation in_user_units(const client::Axis& axis, Expectation expectation) const;

 private:
  client::Result<std::vector<client::Axis>> axes_named(const std::string& name);

  client::Session& session_;
  std::map<std::string, client::Axis> axes_;
  std::map<client::AxisId, std::string> typed_names_;  ///< of axes not named by number
  std::set<std::uint32_t> benches_;
};

/// @param number none = the only bench
/// @param how_to_name advice for when there are several benches
[[nodiscard]] client::Result<client::BenchInfo> find_bench(client::Session& session,
                                                           std::optional<std::uint32_t> number,
                                                           std::string_view how_to_name);

/// @return the bench with this number; without a number all benches, at least one.
[[nodiscard]] client::Result<std::vector<client::BenchInfo>> benches_to_show(
    client::Session& session, std::optional<std::uint32_t> number);

}  // namespace vdrive::tool
