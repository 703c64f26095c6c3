// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "network_participant.hpp"

namespace vdrive::wire {

/// The one function that the shared object of the DDS participants shows, by its name and its type.
using DdsEntry = ParticipantMaker() noexcept;
inline constexpr const char* kDdsEntry = "vdrive_dds_entry";

/// The one text that it shows, a const char*: its build. Who loads it compares the text with its
/// own, VDRIVE_DDS_BUILD, before it calls anything.
inline constexpr const char* kDdsBuild = "vdrive_dds_build";

}  // namespace vdrive::wire
