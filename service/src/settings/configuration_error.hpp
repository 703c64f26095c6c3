// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdrive::settings {

/// A configuration cannot be used. The message has one line per mistake, which names file, line,
/// key, value, unit and limit where they apply.
class ConfigurationError : public std::runtime_error {
 public:
  explicit ConfigurationError(const std::string& mistake);

  /// @param mistakes at least one
  explicit ConfigurationError(std::vector<std::string> mistakes);

  /// @return the lines of the message.
  [[nodiscard]] const std::vector<std::string>& mistakes() const noexcept { return *mistakes_; }

 private:
  /// Shared, because copying an exception must not throw.
  std::shared_ptr<const std::vector<std::string>> mistakes_;
};

/// The mistakes of a file, in the order in which reading finds them.
class Mistakes {
 public:
  /// Nobody reads more of them, and a long file could have millions.
  static constexpr std::size_t kMost = 100;

  /// Reads a part of the file and keeps its ConfigurationError, so that the following parts are
  /// read, too. After kMost mistakes nothing more is read.
  /// @return whether the part was read and had no mistake
  template <typename Read>
  bool collect(const Read& read) {
    if (texts_.size() >= kMost) {
      is_cut_ = true;
      return false;
    }
    try {
      read();
      return true;
    } catch (const ConfigurationError& error) {
      texts_.insert(texts_.end(), error.mistakes().begin(), error.mistakes().end());
      return false;
    }
  }

  /// @throws ConfigurationError with all mistakes, if there are any
  void throw_if_any() const;

 private:
  std::vector<std::string> texts_;
  bool is_cut_ = false;
};

}  // namespace vdrive::settings
