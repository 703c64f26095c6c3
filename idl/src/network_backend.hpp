// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend.hpp"

#include <memory>
#include <string>

namespace vdrive::wire {

/// Makes a backend that reaches a network. @throws what Participant throws
using BackendMaker = std::unique_ptr<Backend> (*)(const NetworkSettings& settings,
                                                  const std::string& name);

/// Priority of functions that provide a backend: before every constructor of a static object, which
/// may make a participant.
inline constexpr int kBeforeConstructors = 101;

/// Makes participants without a local bus use `maker`. A library that has one calls this while the
/// program starts: so no program that links it names it.
void provide_network_backend(BackendMaker maker) noexcept;

/// @throws NetworkError when no library of this program provides a backend
[[nodiscard]] std::unique_ptr<Backend> make_network_backend(const NetworkSettings& settings,
                                                            const std::string& name);

}  // namespace vdrive::wire
