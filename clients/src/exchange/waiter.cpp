// SPDX-License-Identifier: Apache-2.0
#include "exchange/waiter.hpp"

namespace vdrive::client {

std::optional<Outcome> Waiter::end_of_wait(const Target& target, const Patience& patience,
                                           Wakeup::Clock::time_point begin) const {
  if (patience.may_interrupt && wakeup_.is_interrupted()) return Outcome::failed("interrupted");
  if (Outcome present = discovery_.check_samples(target, patience.silence); !present)
    return present;
  if (patience.needs_drive_time && discovery_.is_paused(target.key, begin)) {
    return Outcome::failed(paused_text(target));
  }
  return std::nullopt;
}

Outcome Waiter::timed_out(const Target& target) {
  return Outcome::timed_out(name_of(target) + " did not answer");
}

}  // namespace vdrive::client
