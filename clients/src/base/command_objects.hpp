// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/standing_targets.hpp"
#include "vdrive/dictionary/object.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>

namespace vdrive::client {

/// Adds one of the further objects of a command (up to msg::MAX_OBJECTS_PER_AXIS), which the bench
/// writes after the members of the command and before its controlword.
inline void add_object(msg::AxisCommand& command, ObjectAddress address, std::int64_t value) {
  auto& object = command.objects.emplace_back();
  object.index = address.index;
  object.subindex = address.subindex;
  object.value = value;
}

/// Adds 0 in each of these, which an axis would follow at once when it gets its power.
inline void add_rest(msg::AxisCommand& command) {
  for (const ObjectAddress target : kStandingTargets) add_object(command, target, 0);
}

/// Adds the controlword of a command, or replaces it.
inline void add_word(msg::AxisCommand& command, std::uint16_t word) {
  command.members = static_cast<std::uint16_t>(command.members | msg::HAS_DS402_CONTROLWORD);
  command.ds402_controlword = word;
}

/// Adds one of enabling_words(). With the last one the axis gets its power, and rests unless
/// `keep_target`.
inline void add_enabling_word(msg::AxisCommand& command, std::uint16_t word, bool keep_target) {
  add_word(command, word);
  if (word == controlwords::kEnableOperation && !keep_target) add_rest(command);
}

}  // namespace vdrive::client
