// SPDX-License-Identifier: Apache-2.0
#include "status_json.hpp"

#include "vdrive/number_text.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace vdrive::recording {

const std::vector<StatusMember>& recorded_members() {
  static const std::vector<StatusMember> members = [] {
    std::vector<StatusMember> published;
    std::ranges::copy_if(status_members(), std::back_inserter(published),
                         &StatusMember::is_published);
    std::ranges::stable_sort(published, {}, [](const StatusMember& member) {
      return std::pair(member.address == ObjectAddress{}, member.address);
    });
    return published;
  }();
  return members;
}

std::string to_line(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json status_json(const client::AxisSnapshot& axis, const std::string& name,
                 const std::optional<client::Unit>& unit) {
  Json json{{"axis", to_string(axis.id)},
            {"name", name},
            {"tick", axis.tick},
            {"state", to_string(axis.state())},
            {"flags", client::statusword_flags(axis.status.ds402_statusword, axis.mode())}};
  for (const StatusMember& member : recorded_members()) {
    json[std::string(member.name)] = member.value(axis.status);
  }
  json["owner"] = axis.owner_session == 0 ? Json(nullptr) : Json(session_text(axis.owner_session));
  json["owner_epoch"] = axis.owner_epoch;
  const auto in_unit = [&unit](std::int32_t user_units) {
    return unit ? Json(client::from_user_units(user_units, *unit)) : Json(nullptr);
  };
  json["unit"] = unit ? Json(unit->name) : Json(nullptr);
  json["unit_size"] = unit ? Json(unit->size) : Json(nullptr);
  json["position_in_unit"] = in_unit(axis.status.load_position_actual_value);
  json["velocity_in_unit"] = in_unit(axis.status.load_velocity_actual_value);
  return json;
}

}  // namespace vdrive::recording
