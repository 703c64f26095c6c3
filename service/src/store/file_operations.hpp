// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace vdrive::service {

/// The file operations of the parameter store; a test replaces them and lets each of them fail.
/// Every member throws std::system_error with the errno when the system refuses.
class FileOperations {
 public:
  enum class Purpose : std::uint8_t {
    read,       ///< an existing file, not a link; never waits, whatever it is
    create,     ///< a new file to be written; refused when it exists
    lock,       ///< to be locked, not a link; made when it is not there
    directory,  ///< an existing directory to be synced; a link of root or of this user to one
  };

  /// Who but its owner may use a file or a directory.
  enum class Privacy : std::uint8_t {
    kept,      ///< nobody, as before; or it belongs to root, and not everybody may write
    narrowed,  ///< nobody any more: it belongs to this user
    foreign,   ///< its owner, another user, or everybody
  };

  FileOperations() = default;
  virtual ~FileOperations() = default;
  FileOperations(const FileOperations&) = delete;
  FileOperations& operator=(const FileOperations&) = delete;

  /// Makes a directory whose parent exists, for this user alone; nothing happens when it is there.
  virtual void make_directory(const std::filesystem::path& directory) = 0;
  [[nodiscard]] virtual int open(const std::filesystem::path& file, Purpose purpose) = 0;
  /// Takes the rights of group and others to an open file or directory of this user.
  [[nodiscard]] virtual Privacy make_private(int file) = 0;
  /// @return how many bytes a regular file holds. Anything else is refused with EINVAL.
  [[nodiscard]] virtual std::uint64_t size(int file) = 0;
  /// @return how many bytes were read; 0 at the end.
  [[nodiscard]] virtual std::size_t read(int file, std::span<std::byte> bytes) = 0;
  /// @return how many bytes were written, at least one.
  [[nodiscard]] virtual std::size_t write(int file, std::span<const std::byte> bytes) = 0;
  virtual void sync(int file) = 0;
  /// @return false when somebody else holds the lock.
  [[nodiscard]] virtual bool try_lock(int file) = 0;
  /// @return who has the lock that try_lock did not get, in words.
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
