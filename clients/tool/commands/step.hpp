// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"

#include <cstdint>
#include <optional>

namespace vdrive::tool {

struct StepCommand {
  std::uint64_t ticks = 0;
  std::optional<std::uint32_t> bench{};  ///< none = the only one there is
  std::uint32_t steppers = 0;            ///< that time waits for; 0 = this program alone steps

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;

 private:
  client::Result<std::uint64_t> step(client::Session& session, std::uint32_t number) const;
};

}  // namespace vdrive::tool
