// SPDX-License-Identifier: Apache-2.0
#include "base/file_lock.hpp"

#include "base/system_failure.hpp"
#include "vdrive/text.hpp"

#include <pthread.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <mutex>
#include <sstream>
#include <vector>

namespace vdrive::service {
namespace {

/// The files that this process has locked.
struct LockedFiles {
  std::mutex mutex;
  std::vector<int> files;
};

void begin_fork();
void end_fork() noexcept;
void begin_child() noexcept;

/// Never destroyed: another thread may fork while the process ends.
LockedFiles& locked_files() {
  // NOLINTNEXTLINE(*-avoid-non-const-global-variables): one per process, like its locks
  static LockedFiles* const only = [] {
    ::pthread_atfork(begin_fork, end_fork, begin_child);
    return new LockedFiles;  // NOLINT(cppcoreguidelines-owning-memory): on purpose, see above
  }();
  return *only;
}

void begin_fork() {
  locked_files().mutex.lock();
}

void end_fork() noexcept {
  locked_files().mutex.unlock();
}

/// Closes the child's copies of the locked files. The objects that own these files belong to the
/// parent; the child does not use them.
void begin_child() noexcept {
  for (const int file : locked_files().files) ::close(file);
  locked_files().files.clear();
  locked_files().mutex.unlock();
}

/// @return the process that the kernel lists as the holder of the lock; empty if it lists none.
std::string listed_holder(int file) {
  struct stat status {};

  if (::fstat(file, &status) != 0) return {};
  std::ostringstream wanted;
  wanted << std::hex << std::setfill('0') << std::setw(2) << major(status.st_dev) << ':'
         << std::setw(2) << minor(status.st_dev) << std::dec << ':' << status.st_ino;
  std::ifstream locks("/proc/locks");
  std::string line;
  while (std::getline(locks, line)) {
    // number, FLOCK, ADVISORY, WRITE, process, file, first and last byte
    std::istringstream words(line);
    const std::vector<std::string> fields{std::istream_iterator<std::string>(words), {}};
    if (fields.size() > 5 && fields[1] == "FLOCK" && fields[5] == wanted.str()) return fields[4];
  }
  return {};
}

}  // namespace

bool try_lock_file(int file) {
  LockedFiles& locked = locked_files();
  const std::scoped_lock lock(locked.mutex);
  locked.files.push_back(file);
  if (::flock(file, LOCK_EX | LOCK_NB) == 0) return true;
  locked.files.pop_back();
  if (errno != EWOULDBLOCK) fail("flock");
  return false;
}

int unlock_and_close(int file) noexcept {
  LockedFiles& locked = locked_files();
  const std::scoped_lock lock(locked.mutex);
  if (std::erase(locked.files, file) != 0) static_cast<void>(::flock(file, LOCK_UN));
  return ::close(file);
}

std::string holder_of_lock(int file) {
  const std::string process = listed_holder(file);
  if (process.empty())
    return "a process that is not visible here: it runs on another host or in a container";
  std::ifstream names("/proc/" + process + "/comm");
  std::string name;
  std::getline(names, name);
  return "process " + process + (name.empty() ? "" : " (" + escaped(name) + ")") + " on this host";
}

}  // namespace vdrive::service
