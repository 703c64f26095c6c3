// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// The codes of events that can mean several things. The comments also name the detail of the event
/// (event_record.hpp), if it has one.
namespace vdrive::service {

/// Codes of EVENT_JOURNAL.
struct JournalCode {
  static constexpr std::uint32_t kLosing = 1;   ///< the writer is too slow: ticks are lost
  static constexpr std::uint32_t kResumed = 2;  ///< the journal continues; a Count of lost ticks
  static constexpr std::uint32_t kEnded = 3;    ///< the file cannot be written; a SystemError
};

/// Codes of EVENT_PARAMETERS.
struct ParameterCode {
  static constexpr std::uint32_t kLoaded = 1;      ///< a Count of axes
  static constexpr std::uint32_t kPrevious = 2;    ///< the previous set is used; a StoredProblem
  static constexpr std::uint32_t kDefaults = 3;    ///< configured values are used; a StoredProblem
  static constexpr std::uint32_t kSaveFailed = 4;  ///< a SystemError
};

/// Codes of EVENT_SNAPSHOT; each with the Label of the snapshot.
struct SnapshotCode {
  static constexpr std::uint32_t kTaken = 1;
  static constexpr std::uint32_t kRestored = 2;
  static constexpr std::uint32_t kDropped = 3;
};

/// Codes of EVENT_WALL_CLOCK; each with the time by which the wall clock is ahead of drive time.
struct WallClockCode {
  static constexpr std::uint32_t kSteered = 1;
  static constexpr std::uint32_t kJumped = 2;
};

/// Codes of EVENT_WIRE.
struct WireCode {
  static constexpr std::uint32_t kLost = 1;   ///< a wire ended or was ended; a WireLoss
  static constexpr std::uint32_t kRuns = 2;   ///< another wire runs; the time without one
  static constexpr std::uint32_t kLater = 3;  ///< the next start is delayed; the delay
};

}  // namespace vdrive::service
