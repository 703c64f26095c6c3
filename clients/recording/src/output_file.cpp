// SPDX-License-Identifier: Apache-2.0
#include "output_file.hpp"

#include "recording.hpp"
#include "vdrive/text.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace vdrive::recording {

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  constexpr mode_t kReadableForAll = 0666;  // minus the umask
  file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kReadableForAll);
  if (file_ < 0) fail();
}

OutputFile::~OutputFile() {
  if (file_ >= 0) ::close(file_);
}

void OutputFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail();
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void OutputFile::close() {
  const int file = std::exchange(file_, -1);
  if (file >= 0 && ::close(file) != 0) fail();
}

void OutputFile::fail() const {
  throw RecordingError("cannot write " + in_quotes(path_) + ": " +
                       std::generic_category().message(errno));
}

}  // namespace vdrive::recording
