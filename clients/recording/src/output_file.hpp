// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace vdrive::recording {

/// The destination of the bytes of a recording.
class Output {
 public:
  Output() = default;
  virtual ~Output() = default;
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  /// @throws RecordingError if they cannot be written
  virtual void write(std::string_view bytes) = 0;
};

/// A file written from its beginning. Writes are not buffered in the program: if it is killed,
/// nothing written is lost.
class OutputFile final : public Output {
 public:
  /// Creates the file, or empties an existing one.
  /// @throws RecordingError with the system's reason if it cannot be written
  explicit OutputFile(std::string path);
  ~OutputFile() override;
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// @throws RecordingError with the system's reason, such as a full disk
  void write(std::string_view bytes) override;

  /// @throws RecordingError if the system reports a failed write only now
  void close();

 private:
  [[noreturn]] void fail() const;

  std::string path_;
  int file_ = -1;
};

}  // namespace vdrive::recording
