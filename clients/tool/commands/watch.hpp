// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::tool {

struct WatchCommand {
  std::vector<std::string> axes{};  ///< none = all axes of all benches
  std::uint64_t count = 0;          ///< samples per axis; 0 = until interrupted

  static constexpr bool kBridgesSilence = true;

  /// --timeout limits the wait for a tick, not the search for the axes.
  [[nodiscard]] bool limits_itself() const { return count != 0; }

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool
