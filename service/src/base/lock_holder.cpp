// SPDX-License-Identifier: Apache-2.0
#include "base/lock_holder.hpp"

#include "vdrive/text.hpp"

#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <fstream>
#include <iomanip>
#include <iterator>
#include <sstream>
#include <vector>

namespace vdrive::service {
namespace {

/// @return the process that has the lock, as the kernel lists it; empty where it lists none.
std::string listed_holder(int file) {
  struct stat status {};

  if (::fstat(file, &status) != 0) return {};
  std::ostringstream wanted;
  wanted << std::hex << std::setfill('0') << std::setw(2) << major(status.st_dev) << ':'
         << std::setw(2) << minor(status.st_dev) << std::dec << ':' << status.st_ino;
  std::ifstream locks("/proc/locks");
  std::string line;
  while (std::getline(locks, line)) {
    // Number, FLOCK, ADVISORY, WRITE, process, file, first and last byte.
    std::istringstream words(line);
    const std::vector<std::string> fields{std::istream_iterator<std::string>(words), {}};
    if (fields.size() > 5 && fields[1] == "FLOCK" && fields[5] == wanted.str()) return fields[4];
  }
  return {};
}

}  // namespace

std::string holder_of_lock(int file) {
  const std::string process = listed_holder(file);
  if (process.empty())
    return "a process that this host does not list: it runs on another host or in a container";
  std::ifstream names("/proc/" + process + "/comm");
  std::string name;
  std::getline(names, name);
  return "process " + process + (name.empty() ? "" : " (" + escaped(name) + ")") + " of this host";
}

}  // namespace vdrive::service
