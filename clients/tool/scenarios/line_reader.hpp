// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "child_process.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Reads lines from standard input: on a terminal with a prompt, editing, history and completion.
class LineReader {
 public:
  /// @return what the word at the end of a line could be. @param line up to the cursor
  using Completer = std::function<std::vector<std::string>(const std::string& line)>;

  /// @param history file of the lines of earlier calls; empty = none
  LineReader(const std::string& history, Completer completer);
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  /// @return whether there is a person at a terminal.
  [[nodiscard]] bool is_interactive() const noexcept;

  /// @return the next line without its end; nothing at the end of the input and after end().
  std::optional<std::string> next();

  /// Ends a wait for a line, and every later one. Any thread.
  void end() noexcept;

 private:
  class Editor;
  std::optional<std::string> next_of_pipe();

  process::Descriptor end_;
  std::unique_ptr<Editor> editor_;  ///< none when standard input is no terminal
  std::string ahead_;
};

/// @return the file that keeps the lines of the shell, its directory made; empty where there is no
///         home.
[[nodiscard]] std::string history_file();

}  // namespace vdrive::tool
