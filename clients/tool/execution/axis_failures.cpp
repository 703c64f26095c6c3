// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_failures.hpp"

namespace vdrive::tool {

void AxisFailures::take(client::Outcome reported, const CommandContext& context) {
  if (reported || !messages_.insert(reported.message()).second) return;
  if (first_) {
    first_ = std::move(reported);
  } else {
    context.output.terminal.complain("vdrive: " + context.axes.named(reported).message());
  }
}

}  // namespace vdrive::tool
