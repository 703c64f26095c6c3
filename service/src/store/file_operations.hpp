// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace vdrive::service {

/// The file operations of the parameter store; tests replace them to make each of them fail. All
/// members throw std::system_error with the errno of a failed system call.
class FileOperations {
 public:
  enum class Purpose : std::uint8_t {
    read,       ///< an existing file, not a link; never blocks, whatever it is
    create,     ///< a new file to write; fails if it exists
    lock,       ///< a file to lock, not a link; created if it does not exist
    directory,  ///< an existing directory to sync; a link to one must belong to root or this user
  };

  /// The result of make_private().
  enum class Privacy : std::uint8_t {
    kept,      ///< it was private already, or belongs to root and is not world-writable
    narrowed,  ///< it belongs to this user and is private now
    foreign,   ///< it belongs to another user, or is world-writable
  };

  FileOperations() = default;
  virtual ~FileOperations() = default;
  FileOperations(const FileOperations&) = delete;
  FileOperations& operator=(const FileOperations&) = delete;

  /// Creates a directory for this user only, in an existing parent; does nothing if it exists.
  virtual void make_directory(const std::filesystem::path& directory) = 0;
  [[nodiscard]] virtual int open(const std::filesystem::path& file, Purpose purpose) = 0;
  /// Removes the permissions of group and others from an open file or directory of this user.
  [[nodiscard]] virtual Privacy make_private(int file) = 0;
  /// @return the size of a regular file [bytes]; fails with EINVAL for anything else.
  [[nodiscard]] virtual std::uint64_t size(int file) = 0;
  /// @return the number of bytes read; 0 at the end.
  [[nodiscard]] virtual std::size_t read(int file, std::span<std::byte> bytes) = 0;
  /// @return the number of bytes written, at least one.
  [[nodiscard]] virtual std::size_t write(int file, std::span<const std::byte> bytes) = 0;
  virtual void sync(int file) = 0;
  /// @return false if another process holds the lock.
  [[nodiscard]] virtual bool try_lock(int file) = 0;
  /// @return a description of the holder of the lock that try_lock did not get.
  [[nodiscard]] virtual std::string lock_holder(int file) = 0;
  virtual void close(int file) = 0;
  virtual void rename(const std::filesystem::path& from, const std::filesystem::path& to) = 0;
  virtual void link(const std::filesystem::path& from, const std::filesystem::path& to) = 0;
  virtual void remove(const std::filesystem::path& file) = 0;
  [[nodiscard]] virtual bool exists(const std::filesystem::path& file) = 0;
};

/// @return the operations of the system.
[[nodiscard]] std::unique_ptr<FileOperations> system_files();

}  // namespace vdrive::service
