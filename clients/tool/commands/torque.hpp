// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::tool {

struct TorqueCommand {
  std::string axis{};
  std::int16_t torque = 0;               ///< [‰ of rated torque]
  std::optional<std::uint32_t> slope{};  ///< [‰ of rated torque a second]
  client::Until until = client::Until::done;
  bool take_over = false;

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool
