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
  std::uint16_t network = 1;  ///< number of the bus, the only one that commands may name
  /// 1018h of the gateway, for "info version".
  std::uint32_t vendor_id = 0;
  std::uint32_t product_code = 0;
  std::uint32_t revision_number = 0;
  std::uint32_t serial_number = 0;
};

/// A user of the gateway, such as a TCP connection.
using GatewaySession = std::uint32_t;

/// The callbacks of a gateway. They are called within a call of the gateway and must not call it.
class GatewayHost : public FrameSender {
 public:
  /// The answer to a command, without line end.
  virtual void answer(GatewaySession session, std::string_view line) = 0;

  /// An unsolicited event on the bus: "NET NODE BOOT_UP", or "NET NODE EMCY CODE REGISTER" followed
  /// by the five manufacturer bytes; code and register in hex, bytes in decimal.
  virtual void report(GatewaySession session, std::string_view line) = 0;

  /// See BusHost::disturb().
  [[nodiscard]] virtual std::optional<std::string> disturb(std::uint8_t node,
                                                           std::string_view fault) = 0;
};

/// The gateway of CiA 309-3 (ASCII mapping): sessions send lines with a GatewayCommand, and get one
/// answer to each, in order:
///
///     "[" sequence "]" OK | VALUE | ERROR:0xABORT-CODE #words | ERROR:100 to 107, 401 #words
///
/// The answer to "read pdo" is "NET pdo COUNT VALUE...", and each frame of an RPDO is reported to
/// the session that configured it as "NET pdo NR COUNT VALUE...".
/// The gateway is a master on its bus, with an SDO client for each node and one transfer at a time
/// on each; sessions that command the same node take turns. The default net of a session is the
/// gateway's network; there is no default node. A function of lines, frames and time.
class AsciiGateway final {
 public:
  static constexpr std::chrono::milliseconds kSdoTimeOut{500};  ///< default, until a session sets
                                                                ///< it

  /// @param host outlives the gateway
  AsciiGateway(const GatewaySettings& settings, GatewayHost& host);

  /// @return the id of a new session; ids are never reused.
  GatewaySession open();

  /// Forgets the session: its transfer is aborted, and its waiting lines are dropped.
  void close(GatewaySession session, BusTime now);

  /// Takes a line of an open session. It is carried out once all earlier lines are answered.
  void take_line(GatewaySession session, std::string_view line, BusTime now);

  /// @return the number of lines of an open session that wait for their answer; the caller must
  ///         limit it.
  [[nodiscard]] std::size_t waiting(GatewaySession session) const;

  /// @return whether receive() does anything with `frame`.
  [[nodiscard]] bool awaits(const Frame& frame) const;

  void receive(const Frame& frame, BusTime now);

  /// @return whether a session still has SYNCs to send.
  [[nodiscard]] bool has_syncs() const;

  /// Sends one SYNC, without a counter, for each session that has any left. Only one, so that other
  /// traffic on the bus is not held up.
  void send_sync(BusTime now);

  /// Ends overdue transfers.
  void advance(BusTime now);

  [[nodiscard]] std::optional<BusTime> next_due() const;

 private:
  struct Session {
    std::deque<std::string> lines{};
    std::optional<GatewayCommand> transfer{};  ///< still unanswered
    std::uint64_t syncs = 0;                   ///< still to be sent
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
  std::map<std::uint8_t, Channel> channels_;  ///< by node id; created on first use
  GatewaySession last_session_ = 0;
};

}  // namespace vdrive::canopen
