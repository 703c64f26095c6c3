// SPDX-License-Identifier: Apache-2.0
#include "loader/dds_entry.hpp"

#include "dds/dds_participant.hpp"

extern "C" [[gnu::visibility("default")]] vdrive::wire::DdsEntry vdrive_dds_entry;
// NOLINTBEGIN(readability-identifier-naming): names of symbols
extern "C" [[gnu::visibility("default")]] const char* const vdrive_dds_build;

const char* const vdrive_dds_build = VDRIVE_DDS_BUILD;

// NOLINTEND(readability-identifier-naming)

vdrive::wire::ParticipantMaker vdrive_dds_entry() noexcept {
  return &vdrive::wire::make_dds_participant;
}
