// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

namespace vdrive::wire {

/// Takes over what the DDS library has to complain about: while one of these lives nothing of it is
/// printed. One in a process, made by its program and not by a library.
class LibraryLog {
 public:
  /// Called from the thread of the library's log with the part of the library and its words.
  using Sink = std::function<void(const std::string& part, const std::string& words)>;

  explicit LibraryLog(Sink sink);

  /// From here on nothing is printed: what follows is the end of the process.
  ~LibraryLog();

  LibraryLog(const LibraryLog&) = delete;
  LibraryLog& operator=(const LibraryLog&) = delete;
};

}  // namespace vdrive::wire
