// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace vdrive::canopen {

/// An open file or directory, closed with this object. Each function throws std::system_error when
/// the system refuses.
class StoreFile final {
 public:
  /// @param flags those of open(2); a file that it makes is for this user alone
  StoreFile(const std::filesystem::path& path, int flags);
  ~StoreFile();
  StoreFile(const StoreFile&) = delete;
  StoreFile& operator=(const StoreFile&) = delete;

  void write(std::string_view text) const;
  void sync() const;

  /// @return false when somebody else holds the lock (flock), which ends with this object.
  [[nodiscard]] bool try_lock() const;

  /// Empties the file.
  void clear() const;

  /// @return the first line of at most 200 bytes.
  [[nodiscard]] std::string first_line() const;

 private:
  const int number_;
};

/// Replaces a file: after a failure at any place it is the old one or the new one.
/// @throws std::system_error
void replace_file(const std::filesystem::path& path, std::string_view text);

}  // namespace vdrive::canopen
