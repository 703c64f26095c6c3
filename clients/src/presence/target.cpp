// SPDX-License-Identifier: Apache-2.0
#include "presence/target.hpp"

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"

#include <utility>

namespace vdrive::client {

Target target_of(const PresentBench& bench) {
  return {.key = bench.key(),
          .clock_mode = bench.info.clock_mode,
          .period = bench.info.period,
          .status_every_ticks = bench.info.status_every_ticks,
          .rate = bench.info.rate,
          .is_paused = bench.info.clock_mode == ClockMode::realtime && bench.info.rate == 0.0};
}

std::string name_of(const Target& target) {
  return "bench " + std::to_string(target.key.number);
}

std::string name_of(const Target& target, std::uint16_t axis) {
  return "axis " + to_string(AxisId{target.key.number, axis});
}

std::string paused_text(const Target& target) {
  return name_of(target) + " is paused: rate 0";
}

std::string restarted_text(const Target& target) {
  return name_of(target) + " was restarted: this is a new run of its service";
}

Outcome not_permitted(const Target& target) {
  return Outcome::refused(kNotPermitted, "nothing was sent to " + name_of(target));
}

Outcome refusal_of(const Target& target, const msg::Reply& reply, std::string_view what) {
  std::string message(what);
  message += " refused";
  if (reply.owner_session != 0) {
    const AxisId axis{reply.refused_axis == 0 ? 0 : target.key.number, reply.refused_axis};
    return Outcome::refused(wire::number(reply.reason), std::move(message),
                            {.axis = axis, .session = reply.owner_session});
  }
  if (reply.refused_axis != 0) {
    message += " because of " + name_of(target, reply.refused_axis);
  }
  return Outcome::refused(wire::number(reply.reason), std::move(message));
}

Outcome refusal_of(const Target& target, const msg::CommandReply& reply,
                   std::uint64_t apply_at_tick) {
  const msg::Refusal& refusal = reply.refusals.front();
  if (refusal.axis == 0) {
    std::string message = name_of(target) + " refused the command frame";
    if (refusal.reason == msg::Reason::too_late && apply_at_tick != 0 &&
        apply_at_tick < reply.tick) {
      message += ", late by " + std::to_string(reply.tick - apply_at_tick) + " ticks";
    }
    return Outcome::refused(wire::number(refusal.reason), std::move(message));
  }
  std::string message = name_of(target, refusal.axis) + " refused ";
  if (refusal.index == 0) {
    message += "the command";
  } else {
    const ObjectAddress object{refusal.index, refusal.subindex};
    const auto row = find_object(object);
    message += row ? std::string(vdrive::describe(*row).variable_name) : hex(refusal.index, 4);
    const std::string advice = advice_on(object, static_cast<AbortCode>(refusal.reason));
    if (!advice.empty()) message += ", " + advice;
  }
  return Outcome::refused(wire::number(refusal.reason), std::move(message));
}

}  // namespace vdrive::client
