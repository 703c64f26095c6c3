// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/judged_drive.hpp"

#include <span>
#include <string_view>
#include <vector>

namespace vdrive::judge {

/// A master with one mistake, and one that does the same rightly. Each has a drive of its own.
struct Planted {
  Rule rule{};
  std::vector<std::string> (*wrong)() = nullptr;
  std::vector<std::string> (*right)() = nullptr;
  std::vector<std::string_view> also{};  ///< rules that the same mistake breaks, too
};

/// One for each rule at least.
[[nodiscard]] std::span<const Planted> planted_masters();

}  // namespace vdrive::judge
