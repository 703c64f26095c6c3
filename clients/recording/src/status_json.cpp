// SPDX-License-Identifier: Apache-2.0
#include "status_json.hpp"

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

namespace vdrive::recording {

std::string to_line(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json status_json(const client::AxisSnapshot& axis, const std::string& name) {
  Json json{{"axis", to_string(axis.id)},
            {"name", name},
            {"tick", axis.tick},
            {"state", to_string(axis.state())},
            {"flags", client::statusword_flags(axis.status.ds402_statusword, axis.mode())}};
  for (const ObjectDescription& row : kObjectTable) {
    const auto value = client::value_of(axis, row.address);
    if (value) json[std::string(row.variable_name)] = *value;
  }
  json["ignored_set_points"] = axis.status.ignored_set_points;
  json["fault_count"] = axis.status.fault_count;
  json["owner"] = axis.owner_session == 0 ? Json(nullptr) : Json(session_text(axis.owner_session));
  json["owner_epoch"] = axis.owner_epoch;
  return json;
}

}  // namespace vdrive::recording
