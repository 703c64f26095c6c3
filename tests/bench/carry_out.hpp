// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/programs/command.hpp"
#include "vdrive/client/axis.hpp"

#include <cstdint>

namespace vdrive::bench {

/// Carries out an intent with a call of the client library.
inline client::Outcome carry_out(client::Axis& axis, const test::Intent& intent,
                                 const client::CallOptions& call) {
  using enum test::Intent::Kind;
  switch (intent.kind) {
    case enable:
      return axis.enable(call);
    case disable:
      return axis.disable(call);
    case halt:
      return axis.halt(call);
    case resume:
      return axis.resume({.timeout = call.timeout, .until = client::Until::in_force});
    case quick_stop:
      return axis.quick_stop(call);
    case reset_fault:
      return axis.reset_fault(call);
    case home:
      return axis.home(
          {.method = static_cast<std::int8_t>(intent.value), .offset = 0, .call = call});
    case move_to:
      return axis.move_to(intent.value, {.call = call});
    case move_by:
      return axis.move_by(intent.value, {.call = call});
    case run_at:
      return axis.run_at(intent.value, {.call = call});
    default:
      return axis.apply_torque(static_cast<std::int16_t>(intent.value), {.call = call});
  }
}

}  // namespace vdrive::bench
