// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "terminal/terminal.hpp"

#include <functional>
#include <stop_token>
#include <string>
#include <thread>

namespace vdrive::tool {

/// One line on a terminal that says how far something is that lasts longer than a second. It is
/// rewritten in place, by a thread of its own, and taken away at the end.
class Progress {
 public:
  /// @return what the line has now; empty = no line. Called in the thread of the progress.
  using Text = std::function<std::string()>;

  explicit Progress(Terminal& terminal) : terminal_(terminal) {}

  ~Progress() { end(); }

  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Something begins that `text` tells about; what was told before has ended.
  void tell(Text text);

  /// It has ended: the line is gone, and `text` is not called any more. Without a line: nothing.
  void end();

 private:
  void show(const std::stop_token& stop, const Text& text);

  Terminal& terminal_;
  std::jthread thread_;
};

}  // namespace vdrive::tool
