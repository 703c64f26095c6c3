// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording.hpp"

#include <chrono>
#include <memory>
#include <optional>
#include <string>

namespace vdrive::recording {

/// Opens a file for a recording; an existing one is emptied.
/// @param file its extension selects the format
/// @param version of the program, as information for readers
/// @throws RecordingError if the extension stands for no format or the file cannot be written
[[nodiscard]] std::unique_ptr<Writer> open_recording(const std::string& file,
                                                     const std::string& version);

/// Reads a recording; the extension of the file selects the format.
/// @throws RecordingError if it cannot be read
[[nodiscard]] Contents read_recording(const std::string& file, const SampleHandler& handler);

struct ConvertOptions {
  std::string from;
  std::string to;
  std::optional<std::chrono::nanoseconds> period{};  ///< of a tick, if `from` does not contain it
  std::string version;                               ///< of the program
};

/// Writes the status of one recording to another. All of `from` is read and checked first: if it
/// has an error, nothing is written. Of a truncated MCAP file, the intact part is converted.
/// @throws RecordingError if `from` cannot be read, `to` cannot be written, or both are the same
///         file
Contents convert(const ConvertOptions& options);

}  // namespace vdrive::recording
