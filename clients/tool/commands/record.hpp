// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/recorder.hpp"
#include "language/command.hpp"

#include <string>
#include <vector>

namespace vdrive::tool {

struct RecordCommand {
  std::vector<std::string> axes{};  ///< none = all axes of the only bench
  RecordingChoice choice{};

  static constexpr bool kBridgesSilence = true;

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
};

}  // namespace vdrive::tool
