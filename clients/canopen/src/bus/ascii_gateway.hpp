// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/gateway_command.hpp"
#include "bus/gateway_pdos.hpp"
#include "bus/sdo_client.hpp"
#include "node/frame.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::canopen {

struct GatewaySettings {
  std::uint16_t network = 1;  ///< number of the bus: the only one that commands may name
  /// 1018h of the gateway, for "info version".
  std::uint32_t vendor_id = 0;
  std::uint32_t product_code = 0;
  std::uint32_t revision_number = 0;
  std::uint32_t serial_number = 0;
};

/// A user of the gateway, such as a TCP connection.
using GatewaySession = std::uint32_t;

/// What a gateway does to the world around it. A function is called within a call of the gateway,
/// and calls none of it.
class GatewayHost : public FrameSender {
 public:
  /// The answer to a command, without the end of the line.
  virtual void answer(GatewaySession session, std::string_view line) = 0;

  /// What happened on the bus, unasked: "NET NODE BOOT_UP", and "NET NODE EMCY CODE REGISTER" with
  /// the five bytes of the manufacturer; code and register hexadecimal, bytes decimal.
  virtual void report(GatewaySession session, std::string_view line) = 0;

  /// As BusHost::disturb().
  [[nodiscard]] virtual std::optional<std::string> disturb(std::uint8_t node,
                                                           std::string_view fault) = 0;
};

/// The gateway of CiA 309-3 (ASCII mapping): sessions give lines of GatewayCommand, and get one
/// answer for each command, in their order:
///
///     "[" sequence "]" OK | VALUE | ERROR:0xABORT-CODE #words | ERROR:100 to 107, 401 #words
///
/// That to "read pdo" is "NET pdo COUNT VALUE...", and each frame of an RPDO is reported to the
/// session that has it as "NET pdo NR COUNT VALUE...".
/// It is a master on its bus: an SDO client for each node, one transfer at a time on each; the
/// commands of several sessions for one node take turns. The default net of a session is the
/// gateway's network, its default node none. A function of lines, frames and time.
class AsciiGateway final {
 public:
  static constexpr std::chrono::milliseconds kSdoTimeOut{500};  ///< until a session sets another

  /// @param host outlives the gateway
  AsciiGateway(const GatewaySettings& settings, GatewayHost& host);

  /// @return a session that was never open before.
  GatewaySession open();

  /// Forgets the session: its transfer is aborted, what waits is not carried out.
  void close(GatewaySession session, BusTime now);

  /// Takes a line of an open session. It is carried out when those before it are answered.
  void take_line(GatewaySession session, std::string_view line, BusTime now);

  /// @return how many lines of an open session wait for their answer: the caller bounds them.
  [[nodiscard]] std::size_t waiting(GatewaySession session) const;

  /// @return whether receive() does anything with `frame`.
  [[nodiscard]] bool awaits(const Frame& frame) const;

  void receive(const Frame& frame, BusTime now);

  /// @return whether a session has SYNCs to send.
  [[nodiscard]] bool has_syncs() const;

  /// Sends one SYNC, without a counter, for each session that has some. One at a time: others on
  /// the bus get their turn.
  void send_sync(BusTime now);

  /// Ends what is overdue.
  void advance(BusTime now);

  [[nodiscard]] std::optional<BusTime> next_due() const;

 private:
  struct Session {
    std::deque<std::string> lines{};
    std::optional<GatewayCommand> transfer{};  ///< that is not answered yet
    std::uint64_t syncs = 0;                   ///< that it still has to send
    GatewayPdos pdos{};
    std::optional<std::uint8_t> default_node{};
    std::chrono::milliseconds sdo_time_out = kSdoTimeOut;
    bool has_boot_up = true;
  };

  /// The SDO channel of a node.
  struct Channel {
    SdoClient client;
    std::optional<GatewaySession> user{};
    std::deque<GatewaySession> queue{};
  };

  void work(GatewaySession id, BusTime now);
  void carry_out(GatewaySession id, Session& session, const GatewayCommand& command, BusTime now);
  void set(GatewaySession id, Session& session, const GatewayCommand& command);
  void carry_out_pdo(GatewaySession id, Session& session, const GatewayCommand& command) const;
  void disturb(GatewaySession id, std::uint8_t node, const GatewayCommand& command) const;
  void report_pdos(const Frame& frame);
  void send_nmt(std::uint8_t specifier, std::uint8_t node) const;
  void begin_transfer(GatewaySession id, std::uint8_t node, const GatewayCommand& command,
                      BusTime now);
  void serve(Channel& channel, BusTime now);
  void finish(Channel& channel, BusTime now);
  void report_to_all(const Frame& frame, std::string_view what, bool is_optional) const;
  void report(const Frame& frame) const;
  void answer(GatewaySession id, std::uint32_t sequence, std::string_view text) const;
  void answer_error(GatewaySession id, std::uint32_t sequence, GatewayError error) const;
  [[nodiscard]] std::string version_text() const;

  GatewaySettings settings_;
  GatewayHost& host_;
  std::map<GatewaySession, Session> sessions_;
  std::map<std::uint8_t, Channel> channels_;  ///< by node id; made when it is first used
  GatewaySession last_session_ = 0;
};

}  // namespace vdrive::canopen
