// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <functional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Names that only the benches know. Called when a word of this kind is completed.
struct BenchNames {
  std::function<std::vector<std::string>()> axes;
  std::function<std::vector<std::string>()> benches;
};

/// @return the names that a session sees.
[[nodiscard]] BenchNames names_of(client::Session& session);

}  // namespace vdrive::tool
