// SPDX-License-Identifier: Apache-2.0
#include "bridge/store_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <system_error>

namespace vdrive::canopen {
namespace {

constexpr mode_t kStoreFileMode = 0600;

void require_done(bool is_done) {
  if (!is_done) throw std::system_error(errno, std::generic_category());
}

}  // namespace

StoreFile::StoreFile(const std::filesystem::path& path, int flags)
    // NOLINTNEXTLINE(*-vararg): what the system offers
    : number_(::open(path.c_str(), flags | O_CLOEXEC, kStoreFileMode)) {
  require_done(number_ >= 0);
}

/// The lock of a file belongs to all processes that have it open: one that was forked from this one
/// would keep it.
StoreFile::~StoreFile() {
  static_cast<void>(::flock(number_, LOCK_UN));  // a file without a lock stays as it is
  ::close(number_);
}

void StoreFile::write(std::string_view text) const {
  while (!text.empty()) {
    const ssize_t written = ::write(number_, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    require_done(written > 0);
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void StoreFile::sync() const {
  require_done(::fsync(number_) == 0);
}

bool StoreFile::try_lock() const {
  int result = 0;
  do {
    result = ::flock(number_, LOCK_EX | LOCK_NB);
  } while (result != 0 && errno == EINTR);
  require_done(result == 0 || errno == EWOULDBLOCK);
  return result == 0;
}

void StoreFile::clear() const {
  require_done(::ftruncate(number_, 0) == 0);
}

std::string StoreFile::first_line() const {
  std::array<char, 200> text{};
  const ssize_t count = ::pread(number_, text.data(), text.size(), 0);
  require_done(count >= 0);
  const std::string_view read(text.data(), static_cast<std::size_t>(count));
  return std::string(read.substr(0, read.find('\n')));
}

void replace_file(const std::filesystem::path& path, std::string_view text) {
  const std::filesystem::path next = path.string() + ".new";
  {
    const StoreFile file(next, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW);
    file.write(text);
    file.sync();
  }
  std::filesystem::rename(next, path);
  const StoreFile directory(path.parent_path(), O_RDONLY | O_DIRECTORY);
  directory.sync();
}

}  // namespace vdrive::canopen
