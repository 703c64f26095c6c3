// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "format.hpp"
#include "messages.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/client/event.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::recording {

/// A recording that cannot be written or read. The text names the file, the place and the reason.
class RecordingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An axis of a recording.
struct RecordedAxis {
  client::AxisId id{};
  std::string name{};
  std::string topic{};                 ///< its part of a topic: bridge::topic_names
  std::optional<client::Unit> unit{};  ///< none in a recording that does not say it
};

/// A bench of a recording.
struct RecordedBench {
  std::uint32_t number = 0;
  std::chrono::nanoseconds period{std::chrono::milliseconds(1)};  ///< of a tick, drive time
  std::map<std::string, std::string> facts{};  ///< further ones, for people and programs
  std::vector<RecordedAxis> axes{};
};

/// @return a bench as a recording of some of its axes describes it.
/// @param axes of this bench, all of them known to it
[[nodiscard]] RecordedBench describe(const client::BenchInfo& bench,
                                     const std::vector<client::AxisId>& axes);

/// Gives the axes of a bench, whose ids and names are known, their topics: as the gateway names
/// them.
void name_topics(RecordedBench& bench);

/// @param name, size of a unit as a recording has them: "mm", and [UU] of one or of a revolution
/// @return the unit; nothing where they are none.
[[nodiscard]] std::optional<client::Unit> unit_from(std::string_view name, std::string_view size);

/// @return the names of all axes.
[[nodiscard]] std::map<client::AxisId, std::string> names_of(
    const std::vector<RecordedBench>& benches);

/// Samples of a bench that a recording lacks; or a jump of its tick number: the ticks between were
/// not run, so that nothing is lost.
struct Gap {
  std::uint32_t bench = 0;
  std::uint64_t after = 0;   ///< tick of the sample before, 0 = the recording lacks its beginning
  std::uint64_t before = 0;  ///< tick of the sample after, 0 = the recording lacks its end
  std::uint64_t count = 0;   ///< samples that are missing, or ticks of the jump
};

/// The first gaps, the others as a count.
class GapList {
 public:
  /// How many gaps are kept.
  static constexpr std::size_t kKept = 1000;

  /// @param noun such as "gap"
  explicit GapList(std::string_view noun) : noun_(noun) {}

  void add(const Gap& gap);

  [[nodiscard]] const std::vector<Gap>& kept() const noexcept { return kept_; }

  /// @return samples or ticks of all gaps.
  [[nodiscard]] std::uint64_t total() const noexcept { return total_; }

  /// @return gaps beyond those that are kept.
  [[nodiscard]] std::uint64_t left_out() const noexcept { return left_out_; }

  /// @return such as "between the ticks 12 and 15 of bench 1 (2), and 3 further gaps"; empty when
  ///         there is none.
  /// @param most gaps that are named
  [[nodiscard]] std::string text(std::size_t most) const;

 private:
  std::string_view noun_;
  std::vector<Gap> kept_;
  std::uint64_t total_ = 0;
  std::uint64_t left_out_ = 0;
};

/// What a recording lacks, and what it cannot have, by tick numbers.
class GapLog {
 public:
  /// The next sample of a bench was recorded, with `missed` and `skipped` since the one before that
  /// was recorded.
  void note_sample(const client::Observation& sample);

  /// Samples after the last one were received and not recorded.
  void note_lost_end(std::uint32_t bench, std::uint64_t missed);

  [[nodiscard]] const GapList& missed() const noexcept { return missed_; }

  [[nodiscard]] const GapList& jumps() const noexcept { return jumps_; }

 private:
  std::map<std::uint32_t, std::uint64_t> last_ticks_;
  GapList missed_{"gap"};
  GapList jumps_{"jump"};
};

/// How a recording ended.
struct Summary {
  std::uint64_t samples = 0;      ///< of the status, one a tick of a bench
  std::uint64_t events = 0;       ///< recorded
  std::uint64_t events_lost = 0;  ///< received and not recorded
  GapLog gaps{};
};

/// Takes a recording piece by piece. Each call throws RecordingError when it cannot be written.
class Writer {
 public:
  using Clock = std::chrono::steady_clock;

  Writer() = default;
  virtual ~Writer() = default;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// First: what will be recorded.
  virtual void begin(const std::vector<RecordedBench>& benches) = 0;

  /// One tick of the axes of a bench.
  virtual void status(const client::Observation& sample) = 0;

  virtual void event(const client::Event& event) = 0;

  virtual void parameters(const bridge::ParameterImage& image) = 0;

  /// @param now what was taken some time before it is written to the file
  virtual void flush(Clock::time_point now) = 0;

  /// Last: nothing else follows.
  virtual void finish(const Summary& summary) = 0;
};

/// What a recording that was read contains.
struct Contents {
  std::vector<RecordedBench> benches{};
  std::uint64_t samples = 0;
  std::uint64_t rows = 0;        ///< of the status: one an axis and sample
  std::uint64_t events = 0;      ///< in the file, and skipped
  std::uint64_t parameters = 0;  ///< images seen and passed over
  std::string cut{};             ///< where the file ends before its end; empty for a whole one
};

/// Gets each sample of a recording, in order.
using SampleHandler = std::function<void(const client::Observation&)>;

}  // namespace vdrive::recording
