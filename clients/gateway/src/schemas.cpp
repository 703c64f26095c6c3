// SPDX-License-Identifier: Apache-2.0
#include "schemas.hpp"

#include <sstream>
#include <string>
#include <utility>

namespace vdrive::gateway {
namespace {

Json type_schema(const std::string& type, const Json& types) {
  if (type.ends_with("[]")) {
    return {{"type", "array"}, {"items", type_schema(type.substr(0, type.size() - 2), types)}};
  }
  return types.value(type, Json{{"type", type}});
}

}  // namespace

Json object_schema(std::string_view members, const Json& types) {
  Json properties = Json::object();
  Json required = Json::array();
  std::istringstream stream{std::string(members)};
  for (std::string member; stream >> member;) {
    const auto colon = member.find(':');
    std::string name = member.substr(0, colon);
    if (name.ends_with('?')) {
      name.pop_back();
    } else {
      required.push_back(name);
    }
    properties[name] = type_schema(member.substr(colon + 1), types);
  }
  return {
      {"type", "object"}, {"properties", std::move(properties)}, {"required", std::move(required)}};
}

}  // namespace vdrive::gateway
