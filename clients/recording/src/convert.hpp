// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording.hpp"

#include <chrono>
#include <memory>
#include <optional>
#include <string>

namespace vdrive::recording {

/// Opens a file for a recording; an existing one is emptied.
/// @param file its ending decides the format
/// @param version of the program, for people
/// @throws RecordingError when the ending stands for no format or the file cannot be written
[[nodiscard]] std::unique_ptr<Writer> open_recording(const std::string& file,
                                                     const std::string& version);

/// Reads a recording; its ending decides the format.
/// @throws RecordingError when it cannot be read
[[nodiscard]] Contents read_recording(const std::string& file, const SampleHandler& handler);

struct ConvertOptions {
  std::string from;
  std::string to;
  std::optional<std::chrono::nanoseconds> period{};  ///< of a tick, where `from` does not have it
  std::string version;                               ///< of the program
};

/// Writes the status of one recording as another. All of `from` is read and checked first: where it
/// has an error nothing is written. Of an MCAP file that was cut off the whole part is converted.
/// @throws RecordingError when `from` cannot be read, `to` not be written, or both are the same
/// file
Contents convert(const ConvertOptions& options);

}  // namespace vdrive::recording
