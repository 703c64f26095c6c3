// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "local/fair_shared_mutex.hpp"
#include "message_support.hpp"
#include "vdrive/wire/local_bus.hpp"
#include "vdrive/wire/origin.hpp"
#include "vdrive/wire/participant.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::wire {

class LocalParticipant;
class LocalReader;
class LocalWriter;

/// A participant as numbers, which compare faster than its bytes.
using SourceKey = std::pair<std::uint64_t, std::uint32_t>;

/// The members of a bus. A thread that delivers a sample shares `members`; a reader or writer that
/// joins or leaves owns it exclusively, so that nothing is delivered to an object that is gone. A
/// handler must not write a sample, which would lock `members` twice.
struct LocalBus::Parts {
  /// The work of a bench, alive as long as a thread runs it.
  struct Place {
    Work work;
    std::shared_mutex in_use;  ///< shared by the threads that run the work
    bool has_ended = false;    ///< guarded by in_use
  };

  /// @return null when no such bench is on the bus.
  [[nodiscard]] std::shared_ptr<Place> place_of(std::uint32_t bench);

  const Origin origin;

  std::mutex counting;  ///< handlers lock it too, so no lock is taken while it is held
  std::vector<const LocalParticipant*> participants;
  /// Sources of the participants, sorted: each call of a session looks up its bench here.
  std::vector<SourceKey> sources;

  FairSharedMutex members;
  std::array<std::vector<LocalReader*>, kTopics.size()> readers;
  std::array<std::vector<LocalWriter*>, kTopics.size()> writers;

  std::mutex joining;  ///< no lock is taken while it is held
  std::map<std::pair<ClockOfBench, std::uint64_t>, std::uint64_t>
      joined_threads;  ///< by clock and session

  std::mutex placing;                                      ///< no lock is taken while it is held
  std::map<std::uint32_t, std::shared_ptr<Place>> places;  ///< by bench
};

/// A participant on a local bus. It knows exactly who is there: others join and leave the bus, and
/// a service whose name is taken is refused when it joins.
class LocalParticipant final : public Participant, public Presence {
 public:
  /// @throws NameTaken when a service on the bus already has this name; NetworkError in a forked
  ///         process
  LocalParticipant(std::shared_ptr<LocalBus> bus, Role role, std::string name);
  ~LocalParticipant() override;
  LocalParticipant(const LocalParticipant&) = delete;
  LocalParticipant& operator=(const LocalParticipant&) = delete;

  std::unique_ptr<SampleWriter> make_writer(TopicId topic,
                                            SampleWriter::Observer observer) override;
  std::unique_ptr<SampleReader> make_reader(TopicId topic, SampleHandler handler) override;

  [[nodiscard]] std::string place() const override { return "on this bus"; }

  [[nodiscard]] Source source() const noexcept override { return source_; }

  [[nodiscard]] Presence& presence() noexcept override { return *this; }

  [[nodiscard]] std::vector<OtherParticipant> others(std::string_view beginning) const override;

  [[nodiscard]] bool may_miss_some() const noexcept override { return false; }

  [[nodiscard]] bool is_certain(const Source& source) const noexcept override;

  [[nodiscard]] bool may_have_double() const noexcept override { return false; }

  [[nodiscard]] bool may_return() const noexcept override { return false; }

  [[nodiscard]] Clock::duration own_pauses(Clock::time_point /*now*/) override { return {}; }

  [[nodiscard]] std::optional<std::chrono::milliseconds> pulse() const noexcept override {
    return std::nullopt;
  }

  [[nodiscard]] std::optional<Clock::duration> silence(
      const Source& source, std::optional<Clock::time_point> /*newest_sample*/,
      Clock::time_point /*now*/) const noexcept override {
    return is_certain(source) ? std::optional(Clock::duration()) : std::nullopt;
  }

  [[nodiscard]] bool is_excused(Clock::time_point /*now*/) const override { return false; }

  LocalWork run_local_work(std::uint32_t bench) override { return bus_->run_work(bench); }

  bool make_room(std::uint32_t bench) override { return bus_->make_room(bench); }

  std::uint64_t join_clock(const ClockOfBench& clock, std::uint64_t session) override;
  void leave_clock(const ClockOfBench& clock, std::uint64_t session) noexcept override;
  void leave_clocks(std::uint64_t session) noexcept override;

 private:
  std::shared_ptr<LocalBus> bus_;
  Role role_;
  std::string name_;
  Source source_;
};

/// A writer on a local bus. Keeps the history of its topic for late readers.
class LocalWriter final : public SampleWriter {
 public:
  LocalWriter(std::shared_ptr<LocalBus> bus, const Source& source, TopicId topic,
              Observer observer);
  ~LocalWriter() override;
  LocalWriter(const LocalWriter&) = delete;
  LocalWriter& operator=(const LocalWriter&) = delete;

  bool write(std::span<const std::byte> sample) noexcept override;

  bool wait_for_acknowledged(std::chrono::milliseconds /*timeout*/) override { return true; }

  // Require exclusive ownership of `members`:
  void match(const LocalReader& reader);
  void unmatch(const LocalReader& reader);
  void replay(LocalReader& reader) const;

  [[nodiscard]] const EndpointId& id() const noexcept { return id_; }

 private:
  void keep(std::span<const std::byte> sample);
  void report_matches() const;

  std::shared_ptr<LocalBus> bus_;
  EndpointId id_;
  TopicId topic_;
  Observer observer_;
  std::mutex writing_;  ///< keeps deliveries to each reader in the order of the history
  std::map<MessageKey, std::deque<std::vector<std::byte>>> history_;
};

/// A reader on a local bus.
class LocalReader final : public SampleReader {
 public:
  LocalReader(std::shared_ptr<LocalBus> bus, const Source& source, TopicId topic,
              SampleHandler handler);
  ~LocalReader() override;
  LocalReader(const LocalReader&) = delete;
  LocalReader& operator=(const LocalReader&) = delete;

  [[nodiscard]] std::size_t lost() const noexcept override { return 0; }

  void take(std::span<const std::byte> sample, const Source& source);

  [[nodiscard]] const EndpointId& id() const noexcept { return id_; }

 private:
  std::shared_ptr<LocalBus> bus_;
  EndpointId id_;
  TopicId topic_;
  SampleHandler handler_;
  std::mutex taking_;  ///< one sample at a time
};

}  // namespace vdrive::wire
