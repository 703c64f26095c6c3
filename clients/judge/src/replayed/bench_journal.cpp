// SPDX-License-Identifier: Apache-2.0
#include "replayed/bench_journal.hpp"

#include "journal/replay.hpp"
#include "judge/bench_records.hpp"
#include "vdrive_messages.hpp"

#include <chrono>
#include <cstddef>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace vdrive::judge {
namespace {

using service::JournalAuthor;
using service::JournalChange;
using service::JournalRefusal;
using service::JournalSnapshot;

/// The first byte of a journal: its first chunk is of kind 1. No bus log begins with it.
constexpr int kFirstByte = 1;

/// A difference persists, so it is found without checking every tick.
constexpr std::uint64_t kTicksACheck = 16;

/// An axis at rest gets a record only every so many ticks: most of a journal is standstill.
constexpr std::uint64_t kTicksOfTheSame = 8;

/// Converts the events of a replay to records.
class JournalJudge final : public service::ReplayObserver {
 public:
  void begins(const service::Configuration& configuration, bool has_authors) override {
    period_ = configuration.period;
    has_authors_ = has_authors;
    result_.bench = configuration.bench;
    for (const auto& axis : configuration.axes) numbers_.push_back(axis.number);
    ignored_.resize(numbers_.size());
    shown_.resize(numbers_.size());
    judge_.emplace(SourceFacts{.has_time = true,
                               .shows_reads = false,
                               .shows_sessions = has_authors,
                               .speed_is_per_second = true});
    if (!has_authors) {
      result_.notes.emplace_back(
          "a journal of an older version: it does not record who wrote, and what was refused");
    }
  }

  void restored(const JournalSnapshot& snapshot, const AxisBank& bank) override {
    tick_ = snapshot.tick;
    const bool is_start = snapshot.cause == JournalSnapshot::Cause::start;
    if (snapshot.cause == JournalSnapshot::Cause::resumed) ++gaps_;
    for (std::size_t axis = 0; axis < bank.size(); ++axis) {
      if (!is_start) lose(axis, is_resumed(snapshot) ? "ticks are missing" : "snapshot");
      show_objects(axis, bank);
      take(axis, shown_by(bank.status(axis)));
    }
  }

  void entered(const JournalAuthor& author, const AxisBank& /*bank*/) override { author_ = author; }

  void entered(const JournalRefusal& refusal, const AxisBank& /*bank*/) override {
    if (is_test_input(refusal.address)) return;
    const bool is_late = refusal.reason == wire::number(msg::Reason::too_late);
    take(refusal.axis, Write{.object = refusal.address,
                             .value = refusal.value,
                             .channel = channel(),
                             .fate = is_late ? Fate::late : Fate::refused,
                             .code = refusal.reason,
                             .writer = author_.session});
  }

  void entered(const JournalChange& change, const AxisBank& bank) override {
    switch (change.kind) {
      case JournalChange::Kind::write:
        enter_write(change, bank);
        break;
      case JournalChange::Kind::power_cycle:
        lose(change.axis, "power cycle");
        show_objects(change.axis, bank);
        break;
      case JournalChange::Kind::connection_loss:
      case JournalChange::Kind::stored:
      case JournalChange::Kind::forgot:
        break;  // the resulting changes are visible
    }
  }

  void stepped(std::uint64_t tick, const AxisBank& bank) override {
    tick_ = tick;
    for (std::size_t axis = 0; axis < bank.size(); ++axis) {
      // Set-points ignored up to this tick must not be attributed to a later write.
      ignored_[axis] = bank.ignored_set_points(axis);
      const Shown shown = shown_by(bank.status(axis));
      const bool is_same = shown == std::exchange(shown_[axis], shown);
      if (!is_same || tick % kTicksOfTheSame == 0) take(axis, shown);
    }
  }

  JournalVerdict end(bool is_complete) {
    if (gaps_ > 0) {
      result_.notes.push_back("ticks are missing in " + std::to_string(gaps_) +
                              (gaps_ == 1 ? " place" : " places"));
    }
    if (!is_complete && gaps_ == 0) {
      result_.notes.emplace_back(
          "the journal ends early: its bench was killed, or is still running");
    }
    result_.verdict = judge_->end(is_over_ || is_complete);
    return std::move(result_);
  }

 private:
  static bool is_resumed(const JournalSnapshot& snapshot) {
    return snapshot.cause == JournalSnapshot::Cause::resumed;
  }

  [[nodiscard]] Channel channel() const {
    return author_.means == JournalAuthor::Means::frame ? Channel::frame : Channel::request;
  }

  void enter_write(const JournalChange& change, const AxisBank& bank) {
    const std::uint32_t ignored = bank.ignored_set_points(change.axis);
    const bool is_ignored = ignored != std::exchange(ignored_[change.axis], ignored);
    if (is_test_input(change.address)) return;
    // Only the bench writes without an author: it stops its axes, so the run is over.
    is_over_ = is_over_ || (has_authors_ && author_.means == JournalAuthor::Means::none);
    take(change.axis, Write{.object = change.address,
                            .value = change.value,
                            .channel = channel(),
                            .fate = is_ignored ? Fate::ignored : Fate::accepted,
                            .writer = author_.session});
  }

  /// Records a gap, after which the next state is shown even if it is unchanged.
  void lose(std::size_t axis, std::string_view cause) {
    take(axis, Gap{cause});
    shown_[axis] = {};
  }

  void show_objects(std::size_t axis, const AxisBank& bank) {
    ignored_[axis] = bank.ignored_set_points(axis);
    for (const ObjectAddress object : kKnownFromTheStart) {
      const ReadResult result = bank.read(axis, object);
      if (result.code != AbortCode::none) continue;
      take(axis, Reading{.object = object, .value = result.value, .is_of_the_master = false});
    }
  }

  void take(std::size_t axis, const decltype(Record::what)& what) {
    if (is_over_) return;
    judge_->take({.time = static_cast<std::int64_t>(tick_) * Time(period_),
                  .tick = tick_,
                  .axis = numbers_[axis],
                  .what = what});
  }

  std::optional<Judge> judge_;
  std::chrono::microseconds period_{};
  bool has_authors_ = false;
  bool is_over_ = false;  ///< the bench is ending: later writes are not from a master
  JournalAuthor author_;
  std::uint64_t tick_ = 0;
  std::uint64_t gaps_ = 0;
  std::vector<std::uint32_t> numbers_;  ///< axis numbers, by index
  std::vector<std::uint32_t> ignored_;  ///< set-points so far, by index
  std::vector<Shown> shown_;            ///< in the last tick, by index
  JournalVerdict result_;
};

}  // namespace

bool is_journal(std::istream& source) {
  return source.peek() == kFirstByte;
}

JournalVerdict judge_journal(std::istream& journal, std::optional<std::uint32_t> threads) {
  JournalJudge judge;
  const service::ReplayResult result = service::replay(
      journal, {.threads = threads, .check_interval = kTicksACheck, .observer = &judge});
  if (!result.agrees) {
    throw std::runtime_error("the replay differs from it: " + result.text);
  }
  return judge.end(result.is_complete);
}

}  // namespace vdrive::judge
