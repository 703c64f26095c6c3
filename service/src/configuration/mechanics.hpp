// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "settings/rows.hpp"

#include <string>
#include <vector>

namespace vdrive::service {

// `axes[].mechanics`: the machine between motor and load, in physical units. The unit, the gear and
// the limits of the axis follow from it; the drive keeps its 4096 user units per revolution.

/// Reads `mechanics` of an axis, after its `model` and before its `parameters`: sets the unit, the
/// gear (3576h, 3577h) and the software limits (607Dh, 3535h).
/// @throws ConfigurationError if the mechanics are incomplete or contradict themselves, if a value
///         is not a length or a gear, or if they require a finer resolution than one user unit
void read_mechanics(const settings::YamlValue& value, NamedAxis& axis);

/// After the `parameters` of an axis with mechanics: fills in the speeds and ramps that the file
/// does not give, so that the motor turns as fast and accelerates as quickly as that of the default
/// axis. 607Fh follows from 6080h.
void complete_speeds(AxisConfiguration& axis);

/// Adds the keys of `mechanics` at `path`.
void describe_mechanics(const std::string& path, std::vector<settings::ConfigurationKey>& keys);

/// @return the lines of a table that shows a revolution, a user unit and the limits of each axis in
///         the unit of the axis. Axes with the same values share a line.
[[nodiscard]] std::vector<std::string> mechanics_table(const Configuration& configuration);

}  // namespace vdrive::service
