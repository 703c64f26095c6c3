// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/command_context.hpp"
#include "vdrive/client/outcome.hpp"

#include <set>
#include <string>
#include <utility>

namespace vdrive::tool {

/// What failed of a command to several axes. Keeps the first failure for the caller, who prints it;
/// prints each further one once: the loss of a bench is the same failure for all its axes.
class AxisFailures {
 public:
  void take(client::Outcome reported, const CommandContext& context);

  [[nodiscard]] client::Outcome first() && { return std::move(first_); }

 private:
  std::set<std::string> messages_;
  client::Outcome first_;
};

}  // namespace vdrive::tool
