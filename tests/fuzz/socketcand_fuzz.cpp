// SPDX-License-Identifier: Apache-2.0
//
// Any bytes of a client of the socketcand server are words or are refused: dividing them into parts
// differently changes nothing, each answer is one word, and each frame is a classical CAN frame.
#include "bus/socketcand.hpp"
#include "fuzz/support/bytes.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace {

using namespace vdrive::canopen;
using vdrive::test::demand;

/// The calls of a session that received the bytes of a client.
struct SessionLog final : SocketcandHost {
  void reply(std::string_view text) override { replies.emplace_back(text); }

  void send(const Frame& frame) override { frames.push_back(frame); }

  std::vector<std::string> replies;
  std::vector<Frame> frames;
  SocketcandMode mode{};
  bool is_over = false;
  std::uint64_t refused_words = 0;

  friend bool operator==(const SessionLog& a, const SessionLog& b) {
    return std::tie(a.replies, a.frames, a.mode, a.is_over, a.refused_words) ==
           std::tie(b.replies, b.frames, b.mode, b.is_over, b.refused_words);
  }
};

SessionLog run_session(std::string_view bytes, std::size_t part) {
  SessionLog log;
  SocketcandSession session(log);
  session.take("< open can0 >< rawmode >");
  while (!bytes.empty()) {
    session.take(bytes.substr(0, part));
    bytes.remove_prefix(std::min(part, bytes.size()));
  }
  log.mode = session.mode();
  log.is_over = session.is_over();
  log.refused_words = session.refused_words();
  return log;
}

void check_reply(std::string_view reply) {
  demand(reply.starts_with("< ") && reply.ends_with(" >"), "an answer is a word");
  demand(reply.find('<', 1) == std::string_view::npos, "one word");
  demand(reply.find('>') == reply.size() - 1, "with one end");
}

void check_frame(const Frame& frame) {
  demand(frame.size <= kMostData, "a frame has 8 bytes at most");
  demand(frame.id <= (frame.is_extended ? kHighestExtendedId : kHighestBaseId),
         "an identifier has the bits of its format");
  std::string text;
  append_socketcand_frame(text, frame, std::chrono::microseconds(1));
  const std::string_view word = std::string_view(text).substr(1);
  check_reply(word);
  const std::size_t start = word.find(' ', 2) + 1;
  demand(word.find(' ', start) - start == (frame.is_extended ? 8U : 3U),
         "the digits of an identifier tell its format");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(data, data + size);
  const SessionLog log = run_session(bytes, size + 1);
  for (const std::string& reply : log.replies) check_reply(reply);
  for (const Frame& frame : log.frames) check_frame(frame);
  demand(log.refused_words <= log.replies.size(), "each refused word is answered");
  demand(run_session(bytes, 1) == log, "parts change nothing");
  demand(run_session(bytes, 7) == log, "parts change nothing");
  return 0;
}
