// SPDX-License-Identifier: Apache-2.0
#include "vendor/peer.hpp"

#include "support/test_domain.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <stdexcept>

namespace vdrive::test {

Peer::Peer(std::string_view topic, const char* side) {
  std::array<int, 2> down{};
  std::array<int, 2> up{};
  if (pipe2(down.data(), O_CLOEXEC) != 0 || pipe2(up.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error("no pipe");
  }
  std::signal(SIGPIPE, SIG_IGN);  // a failed peer is noticed because its answer is missing
  const std::string name(topic);
  const std::string domain = std::to_string(test_domain());
  setenv("CYCLONEDDS_URI", kCycloneOnLoopback, 1);  // NOLINT(concurrency-mt-unsafe): before fork
  child_ = fork();
  if (child_ == 0) {
    dup2(down[0], STDIN_FILENO);
    dup2(up[1], STDOUT_FILENO);
    execl(VDRIVE_VENDOR_PEER, VDRIVE_VENDOR_PEER, domain.c_str(), name.c_str(), side, nullptr);
    _exit(127);
  }
  close(down[0]);
  close(up[1]);
  to_ = fdopen(down[1], "w");
  from_ = fdopen(up[0], "r");
}

Peer::~Peer() {
  std::fclose(to_);  // the end of its input ends the peer
  std::fclose(from_);
  waitpid(child_, nullptr, 0);
}

bool Peer::match() {
  command("match");
  return read_line() == "matched\n";
}

std::string Peer::write(int filling, std::uint64_t instance, std::uint64_t count) {
  command("write " + std::to_string(filling) + " " + std::to_string(instance) + " " +
          std::to_string(count));
  return read_text();
}

std::string Peer::take(std::chrono::milliseconds patience) {
  command("take " + std::to_string(patience.count()));
  return read_text();
}

void Peer::command(const std::string& line) {
  std::fputs((line + "\n").c_str(), to_);
  std::fflush(to_);
}

/// @return the lines before "end"; empty if the peer has ended.
std::string Peer::read_text() {
  std::string text;
  for (std::string line = read_line(); line != "end\n"; line = read_line()) {
    if (line.empty()) {
      return {};
    }
    text += line;
  }
  return text;
}

std::string Peer::read_line() {
  std::array<char, 1024> line{};
  return std::fgets(line.data(), line.size(), from_) == nullptr ? std::string() : line.data();
}

}  // namespace vdrive::test
