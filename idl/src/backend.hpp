// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "matches.hpp"
#include "vdrive/wire/guard.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive/wire/topics.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {

/// A writer of a backend: what a publication is made of.
class WriterEnd {
 public:
  /// Runs with the participants of the readers that match now, whenever they have changed.
  using Observer = std::function<void(const std::vector<Source>& matched)>;

  WriterEnd() = default;
  virtual ~WriterEnd() = default;
  WriterEnd(const WriterEnd&) = delete;
  WriterEnd& operator=(const WriterEnd&) = delete;

  /// @param data of a writer of messages: a message of the topic's type; of a writer of bytes: a
  ///        std::span<const std::byte>
  /// @return false when the sample was not taken.
  [[nodiscard]] virtual bool write(const void* data) noexcept = 0;

  /// @return false on time-out.
  [[nodiscard]] virtual bool wait_for_acknowledged(std::chrono::milliseconds timeout) = 0;

  [[nodiscard]] Matches& matches() noexcept { return matches_; }

 protected:
  Matches matches_;
};

/// Where a reader brings a sample: first into the memory of a message, or as bytes to a function;
/// then it says who sent it. One sample at a time.
struct SampleSink {
  void* message = nullptr;  ///< of the topic's type, or nullptr for bytes
  std::function<void(std::span<const std::byte> sample)> take;  ///< of bytes
  std::function<void(const Source& source)> deliver;
};

/// A reader of a backend: what a subscription is made of. Nothing is delivered after its end.
class ReaderEnd {
 public:
  ReaderEnd() = default;
  virtual ~ReaderEnd() = default;
  ReaderEnd(const ReaderEnd&) = delete;
  ReaderEnd& operator=(const ReaderEnd&) = delete;

  [[nodiscard]] virtual std::size_t lost() const noexcept = 0;

  [[nodiscard]] Matches& matches() noexcept { return matches_; }

 protected:
  Matches matches_;
};

/// What a participant is made of: DDS, or the local bus of a process. Chosen when a participant is
/// made, and known inside the wire room only.
class Backend {
 public:
  enum class Form : std::uint8_t { messages, bytes };

  Backend() = default;
  virtual ~Backend() = default;
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;

  /// @throws NotPermitted, NetworkError as Publication does
  [[nodiscard]] virtual std::unique_ptr<WriterEnd> make_writer(TopicId topic, Form form,
                                                               WriterEnd::Observer observer) = 0;
  /// @throws NetworkError as Subscription does
  [[nodiscard]] virtual std::unique_ptr<ReaderEnd> make_reader(TopicId topic, SampleSink sink) = 0;

  // What Participant promises, by the same names.
  [[nodiscard]] virtual std::string place() const = 0;
  [[nodiscard]] virtual std::uint32_t domain() const noexcept = 0;
  [[nodiscard]] virtual bool is_closed() const noexcept = 0;
  [[nodiscard]] virtual Source source() const noexcept = 0;
  virtual void announce_again() = 0;
  [[nodiscard]] virtual std::vector<OtherParticipant> others(std::string_view beginning) const = 0;
  [[nodiscard]] virtual bool knows_who_is_there() const noexcept = 0;
  [[nodiscard]] virtual bool has(const Source& source) const noexcept = 0;
  virtual LocalWork run_local_work(std::uint32_t bench) = 0;
  virtual bool make_room(std::uint32_t bench) = 0;
  [[nodiscard]] virtual std::uint64_t join_clock(const ClockOfBench& clock,
                                                 std::uint64_t session) = 0;
  virtual void leave_clock(const ClockOfBench& clock, std::uint64_t session) noexcept = 0;
  virtual void leave_clocks(std::uint64_t session) noexcept = 0;
  [[nodiscard]] virtual GuardCounts guard_counts() const = 0;
};

/// @throws what Participant throws
[[nodiscard]] std::unique_ptr<Backend> make_local_backend(const NetworkSettings& settings,
                                                          const std::string& name);

}  // namespace vdrive::wire
