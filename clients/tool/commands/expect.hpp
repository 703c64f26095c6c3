// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "values/expectation.hpp"

#include <optional>
#include <string>

namespace vdrive::tool {

struct ExpectCommand {
  std::string axis{};
  Expectation expectation{};

  void declare(Arguments& arguments);
  void check_objects() const;
  void check_units(const CommandContext& context, const client::Axis& observed) const;
  client::Outcome run(CommandContext& context) const;
};

/// Waits for a drive time, or until an axis meets a condition or an expectation: exactly one of
/// them.
struct WaitCommand {
  std::optional<Duration> duration{};
  std::string axis{};
  std::string condition{};  ///< one of condition_names()
  std::optional<Expectation> expectation{};

  void declare(Arguments& arguments);
  void check_objects() const;
  void check_units(const CommandContext& context, const client::Axis& observed) const;
  client::Outcome run(CommandContext& context) const;

  /// --timeout limits the wait for an axis, not the search for it.
  [[nodiscard]] bool limits_itself() const { return !duration; }
};

}  // namespace vdrive::tool
