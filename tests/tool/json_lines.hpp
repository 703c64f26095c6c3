// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tool/process.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace vdrive::test {

using Json = nlohmann::ordered_json;

/// Parses the output, each line of which must be JSON.
inline std::vector<Json> json_of(const Finished& finished) {
  std::vector<Json> objects;
  for (const std::string& line : finished.lines()) {
    EXPECT_TRUE(Json::accept(line)) << line;
    if (Json::accept(line)) objects.push_back(Json::parse(line));
  }
  return objects;
}

/// @return the keys in order.
inline std::vector<std::string> keys(const Json& json) {
  std::vector<std::string> names;
  for (const auto& [key, value] : json.items()) names.push_back(key);
  return names;
}

}  // namespace vdrive::test
