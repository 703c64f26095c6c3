// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend.hpp"

#include <memory>
#include <string>

namespace vdrive::wire {

/// @return a participant of a DDS domain.
/// @throws what Participant throws
[[nodiscard]] std::unique_ptr<Backend> make_dds_backend(const NetworkSettings& settings,
                                                        const std::string& name);

}  // namespace vdrive::wire
