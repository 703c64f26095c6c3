// SPDX-License-Identifier: Apache-2.0
#include "store/file_operations.hpp"

#include "base/file_lock.hpp"
#include "base/system_failure.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace vdrive::service {
namespace {

constexpr mode_t kFileMode = 0600;
constexpr mode_t kDirectoryMode = 0700;

/// Repeats a call that a signal has interrupted.
template <typename Function>
auto uninterrupted(Function function) {
  auto result = function();
  while (result < 0 && errno == EINTR) result = function();
  return result;
}

int flags_of(FileOperations::Purpose purpose) {
  using enum FileOperations::Purpose;
  switch (purpose) {
    case read:
      return O_RDONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC;
    case create:
      return O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC;
    case lock:
      return O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC;
    case directory:
      return O_RDONLY | O_DIRECTORY | O_CLOEXEC;
  }
  return O_RDONLY;
}

/// A link created by another user could lead anywhere.
bool is_link_of_stranger(const std::filesystem::path& file) {
  struct stat status {};

  if (::lstat(file.c_str(), &status) != 0 || !S_ISLNK(status.st_mode)) return false;
  return status.st_uid != 0 && status.st_uid != geteuid();
}

class SystemFiles final : public FileOperations {
 public:
  void make_directory(const std::filesystem::path& directory) override {
    if (::mkdir(directory.c_str(), kDirectoryMode) != 0 && errno != EEXIST) {
      fail("mkdir " + directory.string());
    }
  }

  int open(const std::filesystem::path& file, Purpose purpose) override {
    if (purpose == Purpose::directory && is_link_of_stranger(file)) {
      errno = ELOOP;
      fail("open " + file.string());
    }
    const int opened = uninterrupted([&] {
      return ::open(file.c_str(), flags_of(purpose), kFileMode);  // NOLINT(*-vararg)
    });
    if (opened < 0) fail("open " + file.string());
    return opened;
  }

  Privacy make_private(int file) override {
    constexpr mode_t kOfOthers = S_IRWXG | S_IRWXO;

    struct stat status {};

    if (::fstat(file, &status) != 0) fail("fstat");
    if (status.st_uid != geteuid()) {
      const bool is_of_root = status.st_uid == 0 && (status.st_mode & S_IWOTH) == 0;
      return is_of_root ? Privacy::kept : Privacy::foreign;
    }
    if ((status.st_mode & kOfOthers) == 0) return Privacy::kept;
    // A directory that everybody may write to, such as /tmp or a volume, is used by others.
    if (S_ISDIR(status.st_mode) && (status.st_mode & S_IWOTH) != 0) return Privacy::foreign;
    if (::fchmod(file, status.st_mode & S_IRWXU) == 0) return Privacy::narrowed;
    if (errno != EROFS) fail("fchmod");
    return Privacy::kept;  // on a read-only file system nobody can write
  }

  std::uint64_t size(int file) override {
    struct stat status {};

    if (::fstat(file, &status) != 0) fail("fstat");
    if (!S_ISREG(status.st_mode)) {
      throw std::system_error(EINVAL, std::generic_category(), "not a regular file");
    }
    return static_cast<std::uint64_t>(status.st_size);
  }

  std::size_t read(int file, std::span<std::byte> bytes) override {
    const auto count = uninterrupted([&] {
      return ::read(file, bytes.data(), bytes.size());
    });
    if (count < 0) fail("read");
    return static_cast<std::size_t>(count);
  }

  std::size_t write(int file, std::span<const std::byte> bytes) override {
    const auto count = uninterrupted([&] {
      return ::write(file, bytes.data(), bytes.size());
    });
    if (count <= 0) fail("write");
    return static_cast<std::size_t>(count);
  }

  void sync(int file) override {
    if (::fsync(file) != 0) fail("fsync");
  }

  bool try_lock(int file) override { return try_lock_file(file); }

  std::string lock_holder(int file) override { return holder_of_lock(file); }

  void close(int file) override {
    if (unlock_and_close(file) != 0) fail("close");
  }

  void rename(const std::filesystem::path& from, const std::filesystem::path& to) override {
    if (::rename(from.c_str(), to.c_str()) != 0) fail("rename " + from.string());
  }

  void link(const std::filesystem::path& from, const std::filesystem::path& to) override {
    if (::link(from.c_str(), to.c_str()) != 0) fail("link " + from.string());
  }

  void remove(const std::filesystem::path& file) override {
    if (::unlink(file.c_str()) != 0) fail("unlink " + file.string());
  }

  bool exists(const std::filesystem::path& file) override {
    struct stat status {};

    if (::lstat(file.c_str(), &status) == 0) return true;
    if (errno != ENOENT) fail("lstat " + file.string());
    return false;
  }
};

}  // namespace

std::unique_ptr<FileOperations> system_files() {
  return std::make_unique<SystemFiles>();
}

}  // namespace vdrive::service
