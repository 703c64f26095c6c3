// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::tool {

/// A key that a table takes.
enum class Key : std::uint8_t { sort, reverse, faults, next_page, previous_page, first_page, quit };

/// Takes the first key off `typed`: letters, or the escape sequences of the page keys and arrows.
/// What is no key is dropped.
/// @return nothing where `typed` is empty, or ends within an escape sequence.
[[nodiscard]] std::optional<Key> take_key(std::string& typed);

/// The keys that are pressed while a command runs on a terminal. Until its end the terminal sends
/// each key at once and does not echo it; Ctrl-C stays a signal. Where standard input is no
/// terminal there are no keys.
class KeyInput {
 public:
  KeyInput();
  ~KeyInput();
  KeyInput(const KeyInput&) = delete;
  KeyInput& operator=(const KeyInput&) = delete;

  /// Does not wait. @return the next key.
  std::optional<Key> next();

  /// Gives the terminal back without a lock, before the process ends at once.
  static void restore_at_once() noexcept;

 private:
  bool is_active_ = false;
  std::string typed_;
};

}  // namespace vdrive::tool
