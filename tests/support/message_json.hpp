// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/cdr.hpp"
#include "vdrive/wire/description.hpp"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <string>
#include <string_view>

namespace vdrive::wire {

/// @return an IDL message as JSON, with all its members, for the output of a failing test.
template <DescribedStruct Struct>
nlohmann::ordered_json json_of(const Struct& message);

template <typename Value>
nlohmann::ordered_json json_of_value(const Value& value) {
  if constexpr (DescribedStruct<Value>) {
    return json_of(value);
  } else if constexpr (CdrNumber<Value>) {
    return value;
  } else if constexpr (CdrSequence<Value>) {
    auto elements = nlohmann::ordered_json::array();
    for (const auto& element : value) elements.push_back(json_of_value(element));
    return elements;
  } else {
    return std::string(std::string_view(value));
  }
}

template <DescribedStruct Struct>
nlohmann::ordered_json json_of(const Struct& message) {
  auto json = nlohmann::ordered_json::object();
  for_each_member<Struct>([&](const auto& member) {
    json[std::string(member.name)] = json_of_value(message.*member.pointer);
  });
  return json;
}

}  // namespace vdrive::wire
