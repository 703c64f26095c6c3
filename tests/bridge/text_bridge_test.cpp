// SPDX-License-Identifier: Apache-2.0
// The example of a bridge, unchanged, with a service.
#include "client/session_options.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"

#include <boost/asio/ip/tcp.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace vdrive::test {
namespace {

using testing::StartsWith;

constexpr std::chrono::seconds kPatience{60};  // far longer than an answer takes

/// The bridge, with a client connected to it.
class TextClient {
 public:
  TextClient()
      : bridge_(VDRIVE_TEXT_BRIDGE, {std::to_string(test_domain()), "0"}),
        port_(port_in(bridge_.read_line())) {
    connection_.expires_after(kPatience);
    connection_.connect("127.0.0.1", port_);
  }

  /// @return the next line; empty if there is none.
  std::string read() {
    connection_.expires_after(kPatience);
    std::string line;
    std::getline(connection_, line);
    return line;
  }

  /// @return the answer to a line: the next line that is not a notification about a bench.
  std::string ask(const std::string& line) {
    connection_ << line << '\n' << std::flush;
    std::string answer = read();
    while (answer.starts_with("bench ")) answer = read();
    return answer;
  }

  /// @return whether this line arrives.
  bool wait_for(const std::string& line) {
    for (std::string next = read(); !next.empty(); next = read()) {
      if (next == line) return true;
    }
    return false;
  }

  /// Repeats the line until the answer contains this text.
  /// @return the answer
  std::string ask_until(const std::string& line, const std::string& text) {
    std::string answer = ask(line);
    while (!answer.empty() && answer.find(text) == std::string::npos) answer = ask(line);
    return answer;
  }

  int stop() {
    bridge_.send(SIGTERM);
    return bridge_.wait().code;
  }

 private:
  static std::string port_in(const std::string& line) { return line.substr(line.rfind(':') + 1); }

  Process bridge_;
  std::string port_;
  boost::asio::ip::tcp::iostream connection_;
};

TEST(TextBridge, EnablesMovesAndStopsAnAxis) {
  const RunningService service(patient("--clock realtime --axes 2"));
  TextClient client;
  ASSERT_TRUE(client.wait_for("bench 1 is there"));
  EXPECT_EQ(client.ask("list"), "1.1 1.2");
  EXPECT_THAT(client.ask("status 1.1"), StartsWith("1.1 Switch on disabled at "));
  EXPECT_EQ(client.ask("enable 1.1"), "ok");
  EXPECT_EQ(client.ask("move 1.1 1000"), "ok");
  EXPECT_THAT(client.ask_until("status 1.1", " at 1000"),
              StartsWith("1.1 Operation enabled at 1000"));
  EXPECT_EQ(client.ask("move 1.1 100000"), "ok");
  EXPECT_EQ(client.ask("stop"), "ok");
  EXPECT_EQ(client.stop(), 0);
}

TEST(TextBridge, AnswersWrongWordsAndUnknownAxes) {
  const RunningService service(patient("--clock realtime --axes 1"));
  TextClient client;
  ASSERT_TRUE(client.wait_for("bench 1 is there"));
  EXPECT_EQ(client.ask("jump 1.1"), "error: 'jump' is none of list, status, enable, move, stop");
  EXPECT_EQ(client.ask(""), "error: '' is none of list, status, enable, move, stop");
  EXPECT_EQ(client.ask("enable 1.7"), "error: there is no axis '1.7'");
  EXPECT_EQ(client.ask("status x"), "error: there is no axis 'x'");
  EXPECT_EQ(client.ask("move 1.1 far"), "error: 'far' is no position");
  EXPECT_EQ(client.ask("move 1.1 3000000000"), "error: '3000000000' is no position");
  EXPECT_THAT(client.ask("move 1.1 100"), StartsWith("error: ")) << "it is not enabled";
}

TEST(TextBridge, TellsThatABenchComesAndGoes) {
  TextClient client;
  EXPECT_EQ(client.ask("list"), "no axis");
  RunningService service(patient("--clock realtime --axes 1"));
  ASSERT_TRUE(client.wait_for("bench 1 is there"));
  EXPECT_EQ(client.ask("list"), "1.1");
  EXPECT_EQ(service.stop().code, 0);
  ASSERT_TRUE(client.wait_for("bench 1 has gone"));
  EXPECT_EQ(client.ask("status 1.1"), "error: there is no axis '1.1'");
  EXPECT_EQ(client.ask("list"), "no axis");
}

}  // namespace
}  // namespace vdrive::test
