// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive_messages.h"

namespace vdrive::wire {

/// The generated code takes sequences of any length; strings it cuts.
/// @return whether every sequence of `message` is within the bound of the IDL.
[[nodiscard]] bool within_bounds(const msg::CommandFrame& message) noexcept;
[[nodiscard]] bool within_bounds(const msg::CommandReply& message) noexcept;
[[nodiscard]] bool within_bounds(const msg::Request& message) noexcept;
[[nodiscard]] bool within_bounds(const msg::Reply& message) noexcept;
[[nodiscard]] bool within_bounds(const msg::StatusFrame& message) noexcept;
[[nodiscard]] bool within_bounds(const msg::AxisStatus& message) noexcept;
[[nodiscard]] bool within_bounds(const msg::AxisParameters& message) noexcept;
[[nodiscard]] bool within_bounds(const msg::Event& message) noexcept;
[[nodiscard]] bool within_bounds(const msg::BenchDescription& message) noexcept;
[[nodiscard]] bool within_bounds(const msg::BenchState& message) noexcept;

}  // namespace vdrive::wire
