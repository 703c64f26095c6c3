// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/conversion.hpp"

#include "status_fields.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace vdrive::wire {
namespace {

static_assert(msg::MAX_SNAPSHOTS == 16 && msg::MAX_STEPPERS == 64,
              "the help of too_many_snapshots and too_many_steppers says so");

/// Reads the object with the name of a member; bench, axis and tick are not objects.
template <std::size_t kMember>
void read_parameter(const AxisBank& bank, std::size_t index, msg::AxisParameters& message) {
  constexpr auto kRow = std::get<kMember>(Description<msg::AxisParameters>::kMembers);
  constexpr auto kObject = find_row(kRow.name);
  static_assert(kObject || kMember < 3, "each further member is an object of the dictionary");
  if constexpr (kObject) {
    auto& value = message.*kRow.pointer;
    value = static_cast<std::remove_reference_t<decltype(value)>>(
        bank.read(index, kObjectRows[*kObject].address).value);
  }
}

}  // namespace

void to_message(const AxisStatus& status, const AxisAddress& address, std::uint64_t tick,
                const Ownership& owner, msg::AxisStatus& message) {
  message.bench = address.bench;
  message.axis = address.axis;
  message.tick = tick;
  message.owner_session = owner.session;
  message.owner_epoch = owner.epoch;
  message.last_sequence = owner.last_sequence;
  for_each_status_member([&](auto member, auto in_message) {
    message.*in_message = status.*member;
  });
}

AxisStatus from_message(const msg::AxisStatus& message) {
  AxisStatus status;
  for_each_status_member([&](auto member, auto in_message) {
    status.*member = message.*in_message;
  });
  return status;
}

void to_message(const AxisBank& bank, std::size_t index, const AxisAddress& address,
                std::uint64_t tick, msg::AxisParameters& message) {
  message.bench = address.bench;
  message.axis = address.axis;
  message.tick = tick;
  constexpr std::size_t kMembers =
      std::tuple_size_v<decltype(Description<msg::AxisParameters>::kMembers)>;
  [&]<std::size_t... kMember>(std::index_sequence<kMember...>) {
    (read_parameter<kMember>(bank, index, message), ...);
  }
  (std::make_index_sequence<kMembers>{});
}

msg::ClockMode to_message(ClockMode mode) noexcept {
  switch (mode) {
    case ClockMode::lockstep:
      return msg::ClockMode::lockstep;
    case ClockMode::freerun:
      return msg::ClockMode::freerun;
    default:
      return msg::ClockMode::realtime;
  }
}

ClockMode from_message(msg::ClockMode mode) noexcept {
  const auto* const known = std::ranges::find_if(kClockModes, [mode](auto each) {
    return to_message(each) == mode;
  });
  return known == kClockModes.end() ? ClockMode::realtime : *known;
}

void to_message(const Unit& unit, msg::AxisDescription& message) {
  message.unit_kind = unit.kind == UnitKind::rotary ? msg::UnitKind::rotary : msg::UnitKind::linear;
  message.unit_name = unit.name;
  message.unit_size = unit.size;
}

Unit unit_of(const msg::AxisDescription& message) {
  const bool is_known =
      message.unit_kind == msg::UnitKind::rotary || message.unit_kind == msg::UnitKind::linear;
  const Unit unit{
      .kind = message.unit_kind == msg::UnitKind::linear ? UnitKind::linear : UnitKind::rotary,
      .name = message.unit_name.to_string(),
      .size = message.unit_size};
  return is_known && is_usable(unit) ? unit : Unit();
}

std::string describe_reason(std::uint32_t reason) {
  if (const auto* const row = value_row(static_cast<msg::Reason>(reason))) {
    return std::string(row->help);
  }
  return hex(reason, 8) + ", " + std::string(vdrive::describe(static_cast<AbortCode>(reason)));
}

}  // namespace vdrive::wire
