// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tool/screen.hpp"

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace vdrive::test {

/// The tool on a pseudo-terminal, on the domain of this test. The destructor kills it if it is
/// still running.
class PseudoTerminal {
 public:
  /// @param environment variables such as "NO_COLOR=1"; TERM is xterm, and NO_COLOR is unset by
  ///         default
  PseudoTerminal(std::size_t rows, std::size_t columns, const std::string& words,
                 const std::vector<std::string>& environment = {});
  ~PseudoTerminal();
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  [[nodiscard]] const Screen& screen() const noexcept { return screen_; }

  /// All output of the program so far.
  [[nodiscard]] const std::string& output() const noexcept { return output_; }

  /// Reads until the screen meets the condition.
  /// @return false after 60 s, and if the program ends first.
  bool wait_until(const std::function<bool(const Screen&)>& is_wanted);

  /// Changes the size, as when the window is dragged.
  void resize(std::size_t rows, std::size_t columns);

  /// Types these characters.
  void type(const std::string& text);

  /// Types Ctrl-C.
  void interrupt();

  /// Reads to the end.
  /// @return the exit code, or -signal.
  int wait();

 private:
  bool read_some();

  Screen screen_;
  std::string output_;
  int terminal_ = -1;
  pid_t child_ = 0;
};

}  // namespace vdrive::test
