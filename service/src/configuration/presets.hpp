// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace vdrive::service {

/// Axes of believable machines: deploy/axes/*.yaml, which every program has in itself.

/// @return their names, such as "ball-screw", in alphabetical order.
[[nodiscard]] std::vector<std::string> preset_names();

/// @return `count` axes of the machine `name`, numbered from 1, named "axis1" and so on.
/// @throws ConfigurationError when no preset has this name, with the names that there are, and when
///         `count` is outside 1 to kMaxAxes.
[[nodiscard]] std::vector<NamedAxis> preset_axes(const std::string& name, std::size_t count);

}  // namespace vdrive::service
