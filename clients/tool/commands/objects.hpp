// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "values/units.hpp"
#include "values/value.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

struct ReadCommand {
  std::string axis{};
  std::vector<ObjectName> objects{};

  void declare(Arguments& arguments);
  void check_objects() const;
  client::Outcome run(CommandContext& context) const;
};

struct WriteCommand {
  std::string axis{};
  ObjectName object{};
  std::int64_t value = 0;
  std::optional<Quantity> quantity{};  ///< the value, if it was given with a unit
  bool take_over = false;

  void declare(Arguments& arguments);
  void check_objects() const;
  void check_units(const CommandContext& context, const client::Axis& written) const;
  client::Outcome run(CommandContext& context) const;
};

/// One test-bench input.
struct Disturbance {
  ObjectName object;
  std::int64_t value = 0;
};

struct DisturbCommand {
  std::string axis{};
  std::vector<Disturbance> inputs{};   ///< several only for `none`
  std::optional<Duration> duration{};  ///< none = until another command clears it

  void declare(Arguments& arguments);
  void check_objects() const;
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool
