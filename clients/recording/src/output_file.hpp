// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace vdrive::recording {

/// A file that is written from its beginning. What was handed over is with the system: the end of
/// the program, however it ends, loses none of it.
class OutputFile {
 public:
  /// Makes the file, or empties the one that is there.
  /// @throws RecordingError with the system's reason when it cannot be written
  explicit OutputFile(std::string path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// @throws RecordingError with the system's reason, such as a full disk
  void write(std::string_view bytes);

  /// @throws RecordingError when the system reports only now what went wrong
  void close();

 private:
  [[noreturn]] void fail() const;

  std::string path_;
  int file_ = -1;
};

}  // namespace vdrive::recording
