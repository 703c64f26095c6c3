// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/deadline.hpp"
#include "support/local_http.hpp"
#include "tool/process.hpp"

#include <gtest/gtest.h>

#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::test {

inline constexpr std::chrono::seconds kProgramPatience{60};

inline std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// A running vdrive-canopen of this build, with a socketcand server on a free port.
class RunningCanopen {
 public:
  explicit RunningCanopen(const std::string& words)
      : RunningCanopen(words_of(words + " --socketcand 127.0.0.1:0")) {}

  /// @param arguments may contain blanks
  explicit RunningCanopen(const std::vector<std::string>& arguments)
      : process_(VDRIVE_CANOPEN, arguments), line_(process_.read_line()) {
    if (!line_.starts_with("vdrive-canopen: bus 1: ")) {
      throw std::runtime_error("vdrive-canopen did not start: " + process_.wait().errors);
    }
  }

  ~RunningCanopen() {
    if (has_ended_) return;
    const Finished finished = stop();
    EXPECT_EQ(finished.code, 0) << finished.errors;
  }

  RunningCanopen(const RunningCanopen&) = delete;
  RunningCanopen& operator=(const RunningCanopen&) = delete;

  [[nodiscard]] const std::string& first_line() const { return line_; }

  [[nodiscard]] int port() const { return port_after("socketcand 127.0.0.1:"); }

  [[nodiscard]] int gateway_port() const { return port_after("gateway 127.0.0.1:"); }

  Finished stop() {
    has_ended_ = true;
    process_.send(SIGTERM);
    return process_.wait();
  }

 private:
  [[nodiscard]] int port_after(std::string_view words) const {
    return std::stoi(line_.substr(line_.find(words) + words.size()));
  }

  Process process_;
  std::string line_;
  bool has_ended_ = false;
};

/// A socketcand client in raw mode.
class SocketcandPeer {
 public:
  explicit SocketcandPeer(int port) : connection_(connected(port)) {
    const timeval patience{.tv_sec = kProgramPatience.count(), .tv_usec = 0};
    (void)setsockopt(connection_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    (void)read_until("< hi >");
    send_text("< open can0 >");
    (void)read_until("< ok >");
    send_text("< rawmode >");
    (void)read_until("< ok >");
  }

  ~SocketcandPeer() { close(connection_); }

  SocketcandPeer(const SocketcandPeer&) = delete;
  SocketcandPeer& operator=(const SocketcandPeer&) = delete;

  void send_text(const std::string& text) const {
    (void)send(connection_, text.data(), text.size(), MSG_NOSIGNAL);
  }

  /// Sends all of `text`, blocking as long as necessary, while another thread may read.
  void send_all(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t sent = send(connection_, text.data(), text.size(), MSG_NOSIGNAL);
      if (sent <= 0) return;  // the reader notices that the rest is missing
      text.remove_prefix(static_cast<std::size_t>(sent));
    }
  }

  /// @return everything received up to and including `text`.
  /// @throws when the connection ends, and after 60 s.
  std::string read_until(const std::string& text) {
    while (received_.find(text) == std::string::npos) {
      std::array<char, 4096> part{};
      const ssize_t got = recv(connection_, part.data(), part.size(), 0);
      if (got <= 0) {
        report_missed_deadline(text, kProgramPatience);
        throw std::runtime_error("no '" + text + "' in '" + received_ + "'");
      }
      received_.append(part.data(), static_cast<std::size_t>(got));
    }
    const std::size_t end = received_.find(text) + text.size();
    std::string taken = received_.substr(0, end);
    received_.erase(0, end);
    return taken;
  }

  /// @return the data of the next frame with this identifier, as hex digits.
  std::string next_data(const std::string& id) {
    (void)read_until("< frame " + id + " ");
    (void)read_until(" ");  // the time
    const std::string data = read_until(">");
    return words_of(data).front();
  }

  /// Reads an object of up to 4 bytes.
  /// @return the data of the answer.
  std::string upload(int node, const std::string& index_and_subindex) {
    send_text("< send " + std::to_string(600 + node) + " 8 40 " + index_and_subindex +
              " 0 0 0 0 >");
    return next_data(std::to_string(580 + node));
  }

 private:
  int connection_;
  std::string received_;
};

}  // namespace vdrive::test
