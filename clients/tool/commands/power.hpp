// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"

#include <cstdint>
#include <optional>

namespace vdrive::tool {

/// Quick stop of all axes of a bench.
struct StopCommand {
  std::optional<std::uint32_t> bench{};  ///< none = the only one
  client::Until until = client::Until::done;

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool
