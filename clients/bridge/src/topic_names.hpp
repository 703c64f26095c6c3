// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace vdrive::bridge {

/// @return the part of a topic that names a bench, such as "bench1".
[[nodiscard]] std::string bench_topic(std::uint32_t bench);

/// The part of a topic that names an axis: letters, digits and _. If two axes of a bench would have
/// the same name, the second one has its number appended.
/// @param axes all axes of a bench
/// @return one name per axis, in their order
[[nodiscard]] std::vector<std::string> topic_names(std::span<const client::AxisInfo> axes);

/// @return whether both lists have the same axes with the same names and units, so that their
///         topics are the same.
[[nodiscard]] bool are_same_axes(std::span<const client::AxisInfo> a,
                                 std::span<const client::AxisInfo> b);

}  // namespace vdrive::bridge
