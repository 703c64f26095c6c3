// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace vdrive::test {

/// A client built on bare topics. It can send what the client library never would, and keeps every
/// message that it receives.
class Probe {
 public:
  static constexpr std::chrono::seconds kPatience{40};  // long enough for a busy machine

  explicit Probe(std::uint32_t domain, std::uint32_t bench = 1)
      : Probe({.domain = domain}, bench) {}

  Probe(const wire::NetworkSettings& network, std::uint32_t bench);

  /// Waits until the bench is announced and can receive requests. @return false after `kPatience`.
  [[nodiscard]] bool find_bench();

  /// @return a request of `kind` with the next request number.
  [[nodiscard]] msg::Request make_request(msg::RequestKind kind);

  /// Sends the request. @return its reply, or nothing after `kPatience`.
  std::optional<msg::Reply> exchange(const msg::Request& request);

  std::optional<msg::Reply> acquire(std::vector<std::uint16_t> axes);
  std::optional<msg::Reply> step(std::uint64_t ticks, std::vector<std::uint16_t> axes = {});
  std::optional<msg::Reply> read(std::uint16_t axis, std::uint16_t index);
  std::optional<msg::Reply> write(std::uint16_t axis, std::uint16_t index, std::int64_t value);

  /// @return a frame of this session with its next sequence number and current epoch.
  [[nodiscard]] msg::CommandFrame make_frame();
  bool send(const msg::CommandFrame& frame);

  /// Waits for the reply to command frame `sequence`. @return nothing after `kPatience`.
  std::optional<msg::CommandReply> reply_to(std::uint64_t sequence);

  /// Waits for an event that meets `condition`. @return nothing after `kPatience`.
  std::optional<msg::Event> event(const std::function<bool(const msg::Event&)>& condition);

  /// Waits until `condition()` holds. It is evaluated after each message and may use the seen_...()
  /// functions. @return false after `kPatience`.
  [[nodiscard]] bool wait_until(const std::function<bool()>& condition);

  /// @return the source of its messages.
  [[nodiscard]] wire::Source source() const { return participant_->source(); }

  // The messages received; for use inside a condition only.
  [[nodiscard]] const std::vector<msg::BenchDescription>& seen_descriptions() const {
    return descriptions_;
  }

  [[nodiscard]] const std::optional<msg::BenchState>& seen_state() const { return state_; }

  [[nodiscard]] const std::optional<msg::StatusFrame>& seen_status() const { return status_; }

  [[nodiscard]] std::size_t seen_parameters() const { return parameter_sets_; }

  [[nodiscard]] bool seen_offline() const;

  // Copies, for use anywhere else.
  [[nodiscard]] std::vector<msg::BenchDescription> descriptions();
  [[nodiscard]] std::optional<msg::StatusFrame> status();

  std::uint64_t client = next_client();  ///< each probe acts as another program
  std::uint64_t session = 0x5678;
  std::uint64_t incarnation = 0;
  std::uint32_t epoch = 0;
  std::uint64_t last_sequence = 0;

 private:
  static std::uint64_t next_client();
  template <typename Message, typename Store>
  auto keep(Store store);
  template <typename Result>
  Result wait_for(const std::function<Result()>& find);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<msg::Reply> replies_;
  std::vector<msg::CommandReply> command_replies_;
  std::vector<msg::Event> events_;
  std::vector<msg::BenchDescription> descriptions_;
  std::optional<msg::BenchState> state_;
  std::optional<msg::StatusFrame> status_;
  std::size_t parameter_sets_ = 0;
  std::uint32_t bench_;
  std::uint64_t last_request_ = 0;

  std::unique_ptr<wire::Participant> participant_;
  wire::Publication<msg::Request> requests_;
  wire::Publication<msg::CommandFrame> frames_;
  wire::Subscription<msg::Reply> reply_reader_;
  wire::Subscription<msg::CommandReply> command_reply_reader_;
  wire::Subscription<msg::Event> event_reader_;
  wire::Subscription<msg::BenchDescription> description_reader_;
  wire::Subscription<msg::BenchState> state_reader_;
  wire::Subscription<msg::StatusFrame> status_reader_;
  wire::Subscription<msg::AxisParameters> parameter_reader_;
};

}  // namespace vdrive::test
