// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "settings/rows.hpp"

#include <string>
#include <vector>

namespace vdrive::service {

/// What moves the load of an axis, in people's units: `axes[].mechanics`. Its unit, its gear and
/// its limits follow from it; the drive keeps its 4096 user units a revolution.

/// Reads `mechanics` of an axis whose `model` is known, before its `parameters`: sets the unit, the
/// gear (3576h, 3577h) and the software limits (607Dh, 3535h).
/// @throws ConfigurationError when the mechanics are incomplete or contradict themselves, when a
///         value is no length or no gear, and when they ask for a finer resolution than that of a
///         user unit.
void read_mechanics(const settings::YamlValue& value, NamedAxis& axis);

/// Gives an axis with mechanics, after its `parameters`, the speeds and ramps that the default axis
/// has at its motor, where the file gives none; 607Fh follows from 6080h.
void complete_speeds(AxisConfiguration& axis);

/// Adds the keys of `mechanics` that stand at `path`.
void describe_mechanics(const std::string& path, std::vector<settings::ConfigurationKey>& keys);

/// @return for each axis what a revolution, a user unit and its limits are in its unit: the lines
///         of a table. Axes with the same facts share a line.
[[nodiscard]] std::vector<std::string> mechanics_table(const Configuration& configuration);

}  // namespace vdrive::service
