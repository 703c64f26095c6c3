// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace vdrive::tool {

/// The user's input is not valid; the message names the text and what is expected. For scenarios it
/// has one line per mistake.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A test could not be judged, because the machine lacks something it needs, such as memory or a
/// bench. It may pass when repeated.
class NotRun : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The mistakes in scenarios, in the order found.
class Mistakes {
 public:
  /// Enough for a reader; a long file could have millions.
  static constexpr std::size_t kMost = 100;

  /// @param mistake with its place; may have several lines
  void note(const std::string& mistake) {
    if (is_full()) return;
    const bool is_told = ++count_ <= kMost;
    text_ += (text_.empty() ? "" : "\n") +
             (is_told ? mistake : "stopped after " + std::to_string(kMost) + " mistakes");
  }

  /// @return whether further mistakes are dropped.
  [[nodiscard]] bool is_full() const noexcept { return count_ > kMost; }

  /// @return one line per mistake; empty if there is none.
  [[nodiscard]] const std::string& text() const noexcept { return text_; }

  /// @throws UsageError with every mistake, if there is any.
  void throw_if_any() const {
    if (!text_.empty()) throw UsageError(text_);
  }

 private:
  std::string text_;
  std::size_t count_ = 0;
};

}  // namespace vdrive::tool
