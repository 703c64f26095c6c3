// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/event.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::bridge {

/// @param own the session of the bridge
/// @return what to report about an event that refuses a command of the bridge: the same text for
///         equal refusals, which are counted; nothing for any other event, and for the refusal of
///         control, which a ControlKeeper reports.
[[nodiscard]] std::optional<std::string> refusal_report(const client::Event& event,
                                                        std::uint64_t own);

}  // namespace vdrive::bridge
