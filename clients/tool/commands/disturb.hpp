// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "values/value.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// One test-bench input.
struct Disturbance {
  ObjectName object;
  std::int64_t value = 0;
};

struct DisturbCommand {
  std::string axis{};
  std::vector<Disturbance> inputs{};   ///< several for `none`
  std::optional<Duration> duration{};  ///< none = until another command clears it

  void declare(Arguments& arguments);
  void check_objects() const;
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool
