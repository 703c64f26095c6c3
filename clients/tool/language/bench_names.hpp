// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <functional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Names that only the benches know. The functions are called only to complete such a name.
struct BenchNames {
  std::function<std::vector<std::string>()> axes;
  std::function<std::vector<std::string>()> benches;
};

/// @return the names visible in a session.
[[nodiscard]] BenchNames names_of(client::Session& session);

}  // namespace vdrive::tool
