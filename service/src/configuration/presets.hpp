// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace vdrive::service {

// Axes of realistic machines, from deploy/axes/*.yaml, which are compiled into each program.

/// @return the names of the presets, such as "ball-screw", in alphabetical order.
[[nodiscard]] std::vector<std::string> preset_names();

/// @return `count` axes of the machine `name`, numbered from 1, named "axis1" and so on.
/// @throws ConfigurationError if no preset has this name (the message lists the names), or if
///         `count` is outside 1 to kMaxAxes
[[nodiscard]] std::vector<NamedAxis> preset_axes(const std::string& name, std::size_t count);

}  // namespace vdrive::service
