// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/judged_drive.hpp"

#include <span>
#include <string_view>
#include <vector>

namespace vdrive::judge {

/// A master with one mistake, and one that does the same correctly. Each has its own drive.
struct Planted {
  Rule rule{};
  std::vector<std::string> (*wrong)() = nullptr;
  std::vector<std::string> (*right)() = nullptr;
  std::vector<std::string_view> also{};  ///< other rules that the same mistake breaks
};

/// At least one for each rule.
[[nodiscard]] std::span<const Planted> planted_masters();

}  // namespace vdrive::judge
