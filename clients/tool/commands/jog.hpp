// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/run_at.hpp"
#include "language/command.hpp"

#include <optional>
#include <string>

namespace vdrive::tool {

struct JogCommand {
  std::string axis{};
  RunAt run_at{};
  std::optional<Duration> duration{};  ///< none = until Enter or an interrupt

  void declare(Arguments& arguments);
  void check_units(const CommandContext& context, const client::Axis& driven) const;
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool
