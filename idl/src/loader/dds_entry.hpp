// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "network_participant.hpp"

namespace vdrive::wire {

/// Type and name of the only function that the shared object of the DDS participants exports.
using DdsEntry = ParticipantMaker() noexcept;
inline constexpr const char* kDdsEntry = "vdrive_dds_entry";

/// Name of the only exported variable, a const char* that identifies the build. The loader compares
/// it with its own VDRIVE_DDS_BUILD before it calls anything.
inline constexpr const char* kDdsBuild = "vdrive_dds_build";

}  // namespace vdrive::wire
