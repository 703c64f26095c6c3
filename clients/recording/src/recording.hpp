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

/// A recording cannot be written or read. The text names the file, the place and the reason.
class RecordingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct RecordedAxis {
  client::AxisId id{};
  std::string name{};
  std::string topic{};                 ///< its part of the topic name: bridge::topic_names
  std::optional<client::Unit> unit{};  ///< none if the recording does not state it
};

struct RecordedBench {
  std::uint32_t number = 0;
  std::chrono::nanoseconds period{std::chrono::milliseconds(1)};  ///< of a tick, drive time
  std::map<std::string, std::string> facts{};                     ///< further information
  std::vector<RecordedAxis> axes{};
};

/// @return the description of a bench for a recording of some of its axes.
/// @param axes axes of this bench, all of them known to it
[[nodiscard]] RecordedBench describe(const client::BenchInfo& bench,
                                     const std::vector<client::AxisId>& axes);

/// Gives the axes of a bench the topics that the gateway would give them. Their ids and names must
/// be set.
void name_topics(RecordedBench& bench);

/// @param name, size of a unit as written in a recording: "mm", and [UU] per unit or per revolution
/// @return the unit; nothing if they do not form one.
[[nodiscard]] std::optional<client::Unit> unit_from(std::string_view name, std::string_view size);

/// @return the names of all axes.
[[nodiscard]] std::map<client::AxisId, std::string> names_of(
    const std::vector<RecordedBench>& benches);

/// Samples of a bench that are missing from a recording; or a jump of its tick number, in which
/// case the ticks in between were not run and nothing is missing.
struct Gap {
  std::uint32_t bench = 0;
  std::uint64_t after = 0;   ///< tick of the previous sample, 0 = the beginning is missing
  std::uint64_t before = 0;  ///< tick of the next sample, 0 = the end is missing
  std::uint64_t count = 0;   ///< missing samples, or ticks of the jump
};

/// The first gaps, and the number of further ones.
class GapList {
 public:
  /// The number of gaps that are kept.
  static constexpr std::size_t kKept = 1000;

  /// @param noun such as "gap"
  explicit GapList(std::string_view noun) : noun_(noun) {}

  void add(const Gap& gap);

  [[nodiscard]] const std::vector<Gap>& kept() const noexcept { return kept_; }

  /// @return the total of samples or ticks of all gaps.
  [[nodiscard]] std::uint64_t total() const noexcept { return total_; }

  /// @return the number of gaps beyond those kept.
  [[nodiscard]] std::uint64_t left_out() const noexcept { return left_out_; }

  /// @param most gaps to name
  /// @return such as "between the ticks 12 and 15 of bench 1 (2), and 3 further gaps"; empty if
  ///         there is none.
  [[nodiscard]] std::string text(std::size_t most) const;

 private:
  std::string_view noun_;
  std::vector<Gap> kept_;
  std::uint64_t total_ = 0;
  std::uint64_t left_out_ = 0;
};

/// The gaps and the jumps of a recording, by tick numbers.
class GapLog {
 public:
  /// Records that the next sample of a bench was recorded, with its `missed` and `skipped` since
  /// the last recorded one.
  void note_sample(const client::Observation& sample);

  /// Records that samples after the last recorded one were received but not recorded.
  void note_lost_end(std::uint32_t bench, std::uint64_t missed);

  [[nodiscard]] const GapList& missed() const noexcept { return missed_; }

  [[nodiscard]] const GapList& jumps() const noexcept { return jumps_; }

 private:
  std::map<std::uint32_t, std::uint64_t> last_ticks_;
  GapList missed_{"gap"};
  GapList jumps_{"jump"};
};

/// The final figures of a recording.
struct Summary {
  std::uint64_t samples = 0;      ///< of the status, one per tick and bench
  std::uint64_t events = 0;       ///< recorded
  std::uint64_t events_lost = 0;  ///< received but not recorded
  GapLog gaps{};
};

/// Writes a recording piece by piece. Each call throws RecordingError if it cannot be written.
class Writer {
 public:
  using Clock = std::chrono::steady_clock;

  Writer() = default;
  virtual ~Writer() = default;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// First call: the benches that will be recorded.
  virtual void begin(const std::vector<RecordedBench>& benches) = 0;

  /// One tick of the axes of a bench.
  virtual void status(const client::Observation& sample) = 0;

  virtual void event(const client::Event& event) = 0;

  virtual void parameters(const bridge::ParameterImage& image) = 0;

  /// If data has waited for some time, writes it to the file.
  /// @param now the present time
  virtual void flush(Clock::time_point now) = 0;

  /// Last call.
  virtual void finish(const Summary& summary) = 0;
};

/// The contents of a recording that was read.
struct Contents {
  std::vector<RecordedBench> benches{};
  std::uint64_t samples = 0;
  std::uint64_t rows = 0;        ///< of the status: one per axis and sample
  std::uint64_t events = 0;      ///< events in the file, which are skipped
  std::uint64_t parameters = 0;  ///< parameter images in the file, which are skipped
  std::string cut{};             ///< where the file is truncated; empty for a complete one
};

/// Receives each sample of a recording, in order.
using SampleHandler = std::function<void(const client::Observation&)>;

}  // namespace vdrive::recording
