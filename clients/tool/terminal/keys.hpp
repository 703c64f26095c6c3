// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::tool {

/// A key that a table handles.
enum class Key : std::uint8_t { sort, reverse, faults, next_page, previous_page, first_page, quit };

/// Takes the first key from `typed`: a letter, or the escape sequence of a page or arrow key. Drops
/// anything else.
/// @return nothing if `typed` is empty or ends within an escape sequence.
[[nodiscard]] std::optional<Key> take_key(std::string& typed);

/// The keys pressed while a command runs on a terminal. While this object exists, the terminal
/// sends each key immediately and without echo; Ctrl-C remains a signal. There are no keys if
/// standard input is not a terminal.
class KeyInput {
 public:
  KeyInput();
  ~KeyInput();
  KeyInput(const KeyInput&) = delete;
  KeyInput& operator=(const KeyInput&) = delete;

  /// @return the next key, without waiting.
  std::optional<Key> next();

  /// Restores the terminal without a lock, immediately before the process ends.
  static void restore_at_once() noexcept;

 private:
  bool is_active_ = false;
  std::string typed_;
};

}  // namespace vdrive::tool
