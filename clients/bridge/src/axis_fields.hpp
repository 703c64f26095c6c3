// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"

#include <string_view>
#include <tuple>

/// The fields of the status messages, for writing and reading.
namespace vdrive::bridge {

/// Calls `visit(name, member)` for each published member of the status.
template <typename Visit>
void for_each_published_member(const Visit& visit) {
  const auto visit_one = [&](const auto& field) {
    if (field.is_published) visit(field.name, field.member);
  };
  std::apply(
      [&](const auto&... fields) {
        (visit_one(fields), ...);
      },
      kStatusFields);
}

/// Calls `visit(name, field_of)` for each field that a status message has for each axis;
/// `field_of(axis)` returns that field of a client::AxisSnapshot.
template <typename Visit>
void for_each_axis_field(const Visit& visit) {
  visit(
      "axis", [](auto& axis) -> auto& { return axis.id.axis; });
  for_each_published_member([&](std::string_view name, auto member) {
    visit(
        name, [member](auto& axis) -> auto& { return axis.status.*member; });
  });
  visit(
      "owner_session", [](auto& axis) -> auto& { return axis.owner_session; });
  visit(
      "owner_epoch", [](auto& axis) -> auto& { return axis.owner_epoch; });
  visit(
      "last_sequence", [](auto& axis) -> auto& { return axis.last_sequence; });
}

}  // namespace vdrive::bridge
