// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

namespace vdrive::wire {

/// Receives the log of the DDS library, which prints nothing while an object of this class exists.
/// At most one per process; the program creates it, not a library.
class LibraryLog {
 public:
  /// Called in the log thread of the library, with the part of the library that logs and the text.
  using Sink = std::function<void(const std::string& part, const std::string& words)>;

  explicit LibraryLog(Sink sink);

  /// Does not restore the output of the library, because the process is ending.
  ~LibraryLog();

  LibraryLog(const LibraryLog&) = delete;
  LibraryLog& operator=(const LibraryLog&) = delete;
};

}  // namespace vdrive::wire
