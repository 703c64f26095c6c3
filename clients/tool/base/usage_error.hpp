// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace vdrive::tool {

/// What the user typed cannot be understood; the message names the text and what is expected. That
/// of scenarios has a line for each mistake.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A test could not be judged: the machine did not give what it needs, such as memory or a bench.
/// It may pass when it is repeated.
class NotRun : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The mistakes of scenarios, in the order in which they are found.
class Mistakes {
 public:
  /// No person reads more of them, and a long file could have millions.
  static constexpr std::size_t kMost = 100;

  /// @param mistake with its place; a line each where it has several
  void note(const std::string& mistake) {
    if (is_full()) return;
    const bool is_told = ++count_ <= kMost;
    text_ += (text_.empty() ? "" : "\n") +
             (is_told ? mistake : "reading ended after " + std::to_string(kMost) + " mistakes");
  }

  /// @return whether further ones would not be told.
  [[nodiscard]] bool is_full() const noexcept { return count_ > kMost; }

  /// @return a line for each mistake; empty without one.
  [[nodiscard]] const std::string& text() const noexcept { return text_; }

  /// @throws UsageError with every mistake, when there is one.
  void throw_if_any() const {
    if (!text_.empty()) throw UsageError(text_);
  }

 private:
  std::string text_;
  std::size_t count_ = 0;
};

}  // namespace vdrive::tool
