// SPDX-License-Identifier: Apache-2.0
#include "bridge/drive_access.hpp"

#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>

namespace vdrive::canopen {

using namespace vdrive::literals;

namespace {

/// @return the abort code for the outcome of a call; 08000020h if the bench could not be reached.
AbortCode abort_code_of(const client::Outcome& outcome) noexcept {
  if (outcome) return AbortCode::none;
  const auto* const row =
      std::ranges::find(kAbortCodes, static_cast<AbortCode>(outcome.code()), &AbortCodeRow::code);
  const bool is_abort = outcome.kind() == client::OutcomeKind::refused &&
                        row != kAbortCodes.end() && row->code != AbortCode::none;
  // Other codes are reasons of the wire, which no standard defines.
  return is_abort ? row->code : AbortCode::cannot_store_or_transfer;
}

}  // namespace

DriveAnswer carry_out(client::Axis& axis, const DriveAccess& access) {
  if (access.value) {
    return {.abort = abort_code_of(axis.write(access.object, *access.value).outcome())};
  }
  const auto value = axis.read(access.object);
  if (!value) return {.abort = abort_code_of(value.outcome())};
  return {.value = *value};
}

std::vector<DriveValue> read_values(client::Axis& axis, std::span<const ObjectAddress> objects) {
  std::vector<DriveValue> values;
  const auto readings = axis.read(objects);
  if (!readings) return values;
  for (const client::ObjectReading& reading : readings->objects) {
    if (reading.code != AbortCode::none) continue;
    values.push_back({.object = reading.object, .value = reading.value});
  }
  return values;
}

client::Outcome tell_connection(client::Axis& axis, bool is_lost) {
  constexpr ObjectAddress kInput = kObjectRows["test_connection_loss"_object].address;
  // The drive reacts to the edge: an earlier loss, or a test, may have left the input at 1.
  client::Outcome cleared = axis.write(kInput, 0).outcome();
  if (!is_lost || !cleared) return cleared;
  return axis.write(kInput, 1).outcome();
}

client::Outcome cycle_power(client::Axis& axis) {
  return axis.power_cycle({.until = client::Until::in_force});
}

}  // namespace vdrive::canopen
