// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/bench_engine.hpp"
#include "support/local_inbox.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace vdrive::test {

inline constexpr std::uint32_t kBench = 4;
inline constexpr std::uint64_t kIncarnation = 1'000;
inline constexpr std::uint64_t kAlice = 0xA11CE;
inline constexpr std::uint64_t kBob = 0xB0B;
inline constexpr std::uint16_t kFirstTwo[] = {1, 2};  ///< axes
inline constexpr msg::Reason kLocalControl{0x08000021};

/// @return a lock-step bench number 4 with `axes` default axes and the watchdog at 100 ms.
[[nodiscard]] service::Configuration bench_configuration(std::size_t axes);

/// An engine with its queues and helpers for two clients; no network, no clock.
struct EngineUnderTest {
  explicit EngineUnderTest(const service::Configuration& configuration = bench_configuration(3));

  /// Handles the message as if it had arrived from the network.
  void receive(const msg::CommandFrame& frame);
  void receive(const msg::Request& request);

  /// Handles the request. @return its reply.
  msg::Reply reply_to(const msg::Request& request);

  [[nodiscard]] msg::Request make_request(msg::RequestKind kind, std::uint64_t session,
                                          std::vector<std::uint16_t> axes = {});
  msg::Reply acquire(std::uint64_t session, std::vector<std::uint16_t> axes);
  msg::Reply write(std::uint64_t session, std::uint16_t axis, std::uint16_t index,
                   std::int64_t value, std::uint8_t subindex = 0);
  msg::Reply read(std::uint16_t axis, std::uint16_t index, std::uint8_t subindex = 0);
  std::int64_t value(std::uint16_t axis, std::uint16_t index, std::uint8_t subindex = 0);

  /// @return a frame with the session's next sequence number and current epoch.
  [[nodiscard]] msg::CommandFrame make_frame(std::uint64_t session);

  /// Takes the oldest reply from the outbox.
  std::optional<msg::Reply> reply();

  /// Takes the oldest command reply from the outbox.
  std::optional<msg::CommandReply> command_reply();

  /// Takes the oldest command reply. @return its reason if it refuses the complete frame.
  std::optional<msg::Reason> frame_refusal();

  /// @return the events of this kind since the last call; events of other kinds are discarded.
  std::vector<service::EventRecord> events(msg::EventKind kind);

  void steps(std::uint64_t count);

  service::Configuration configuration;
  service::Counters counters;
  LocalInbox inbox;
  service::Outbox outbox;
  service::BenchEngine engine;

 private:
  void handle_arrivals();
  std::uint64_t last_request_ = 0;
};

/// Adds a command for `axis` to the frame. @return the command.
msg::AxisCommand& add_command(msg::CommandFrame& frame, std::uint16_t axis);

void set_controlword(msg::AxisCommand& command, std::uint16_t word);

}  // namespace vdrive::test
