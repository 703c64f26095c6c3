// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace vdrive::canopen {

/// The text of the socketcand protocol (linux-can/socketcand, doc/protocol.md): CAN frames over a
/// byte stream, in words such as "< send 601 3 40 0 10 >".

/// The greeting of a server.
inline constexpr std::string_view kSocketcandGreeting = "< hi >";

/// The most characters between the brackets of a client's word. The longest useful one, for an
/// extended frame of 8 bytes, has 41.
inline constexpr std::size_t kLongestSocketcandWord = 256;

/// Frames and data bytes of a connection since it was opened.
struct SocketcandTraffic {
  std::uint64_t received_bytes = 0;  ///< from the bus
  std::uint64_t received_frames = 0;
  std::uint64_t sent_bytes = 0;  ///< by the client
  std::uint64_t sent_frames = 0;
};

/// Appends a frame of the bus for a client: "< frame ID seconds.microseconds HEX >", or "< rtr ID
/// seconds.microseconds DLC >" for a remote frame. ID has exactly three digits in the base format
/// and eight in the extended one: clients distinguish the formats by it. Without data, two spaces
/// precede the closing bracket: clients look for an empty field there.
/// A line feed precedes the first bracket, because python-can 4.1 (Debian) loses the character
/// after each block of complete words: without the line feed that would be the bracket of the next
/// word. Nothing follows the last bracket, because python-can would print a warning for each block.
/// @param time when the frame was on the bus, from an arbitrary origin; negative = 0
void append_socketcand_frame(std::string& out, const Frame& frame, std::chrono::microseconds time);

/// @return "< stat received-bytes received-frames sent-bytes sent-frames >".
[[nodiscard]] std::string socketcand_statistics(const SocketcandTraffic& traffic);

/// The state of a session, which decides the words it accepts.
enum class SocketcandMode : std::uint8_t {
  no_bus,   ///< it must open the bus
  bcm,      ///< it sends frames; subscriptions of this mode are refused
  raw,      ///< it sends frames and receives all frames of the bus
  control,  ///< it receives statistics
};

/// The callbacks of a session. They are called within take() and must not call the session.
class SocketcandHost {
 public:
  virtual ~SocketcandHost() = default;

  /// Sends an answer, in its own segment.
  virtual void reply(std::string_view text) = 0;

  /// Sends a frame on the bus.
  virtual void send(const Frame& frame) = 0;
};

/// One client of a socketcand server, as a function of the bytes that it sends:
///
///     open NAME                   any name of 1 to 16 printable characters: a server has one bus
///     rawmode | bcmmode | controlmode
///     send ID DLC BYTE...         bcm, raw; eight digits of ID = extended format
///     sendrtr ID DLC              bcm, raw
///     statistics MILLISECONDS     control; 0 = none
///     echo
///
/// Answers are "< ok >", "< echo >" and "< error TEXT >"; sending a frame has no answer. A word
/// that is malformed, unknown or refused is counted and answered with an error, and the session
/// continues; only a bus that cannot be opened ends it. Bytes between words are ignored.
class SocketcandSession final {
 public:
  /// @param host outlives the session
  explicit SocketcandSession(SocketcandHost& host) : host_(host) {}

  /// Takes bytes in pieces of any length.
  void take(std::string_view bytes);

  [[nodiscard]] SocketcandMode mode() const noexcept { return mode_; }

  /// @return whether the server must close the connection once the answers are sent.
  [[nodiscard]] bool is_over() const noexcept { return is_over_; }

  /// @return the period of the statistics; 0 = none are sent.
  [[nodiscard]] std::chrono::milliseconds statistics_period() const noexcept {
    return statistics_period_;
  }

  /// @return the number of words answered with an error.
  [[nodiscard]] std::uint64_t refused_words() const noexcept { return refused_words_; }

 private:
  struct Words;

  void take_byte(char byte);
  void end_word();
  void take_command(const Words& words);
  void open(const Words& words);
  bool change_mode(std::string_view command);
  void send(const Words& words);
  void set_statistics(const Words& words);
  void refuse(std::string_view text);

  SocketcandHost& host_;
  SocketcandMode mode_ = SocketcandMode::no_bus;
  std::string word_;  ///< the incomplete last word
  bool is_inside_ = false;
  bool is_too_long_ = false;
  bool is_over_ = false;
  std::chrono::milliseconds statistics_period_{};
  std::uint64_t refused_words_ = 0;
};

}  // namespace vdrive::canopen
