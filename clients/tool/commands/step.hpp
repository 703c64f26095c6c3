// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"

#include <cstdint>
#include <optional>

namespace vdrive::tool {

struct StepCommand {
  std::uint64_t ticks = 0;
  std::optional<std::uint32_t> bench{};  ///< none = the only one there is

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool
