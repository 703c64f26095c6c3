// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "network_participant.hpp"

namespace vdrive::wire {

/// The only function exported by the shared object of the DDS participants; its name and type.
using DdsEntry = ParticipantMaker() noexcept;
inline constexpr const char* kDdsEntry = "vdrive_dds_entry";

/// The only text exported, a const char* that identifies the build. The loader compares it with its
/// own VDRIVE_DDS_BUILD before it calls anything.
inline constexpr const char* kDdsBuild = "vdrive_dds_build";

}  // namespace vdrive::wire
