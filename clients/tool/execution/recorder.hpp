// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "format.hpp"
#include "messages.hpp"
#include "recording.hpp"
#include "recording_queue.hpp"
#include "terminal/terminal.hpp"
#include "values/value.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// What is recorded, and for how long.
struct RecordingChoice {
  std::string file{};  ///< - = standard output
  recording::Format format = recording::Format::csv;
  std::optional<Duration> duration{};             ///< drive time; none = until interrupted
  std::uint64_t count = 0;                        ///< samples of each bench; 0 = until interrupted
  Duration lost_after = std::chrono::minutes(1);  ///< wall time without a sample that ends it
};

/// Axes of one bench whose status stream is recorded.
struct ObservedBench {
  client::BenchInfo info;
  std::vector<client::Axis> axes;
};

/// Records the status images of axes, one sample a bench and tick, until interrupted or for a
/// while: the stream as it comes, with the number of samples that were lost. As MCAP also every
/// object of the axes as it is at the beginning, and the events of the benches and axes.
///
/// The recorder waits without end for a bench whose time stands still, and up to
/// RecordingChoice::lost_after for one that sends nothing. The end or the restart of a service ends
/// the recording.
class Recorder {
 public:
  Recorder(client::Session& session, Terminal& terminal, const RecordingChoice& choice);

  /// @return failed when the file cannot be written, else how the stream ended; ok when it was
  ///         recorded for as long as requested.
  client::Outcome record(const std::vector<ObservedBench>& benches);

  /// @return how far it is, such as "recorded 4812 samples, 20 %". Any thread.
  [[nodiscard]] std::string progress() const;

  /// @return whether the file could be opened and the streams were followed.
  [[nodiscard]] bool has_begun() const noexcept { return has_begun_; }

  /// What was recorded.
  [[nodiscard]] const recording::Summary& summary() const noexcept { return summary_; }

 private:
  struct Track;

  [[nodiscard]] std::unique_ptr<recording::Writer> open();
  client::Result<std::vector<Track>> open_tracks(const std::vector<ObservedBench>& benches);
  static client::Result<std::vector<bridge::ParameterImage>> read_parameters(
      const std::vector<ObservedBench>& benches);
  client::Outcome record_into(std::unique_ptr<recording::Writer> writer,
                              const std::vector<ObservedBench>& benches,
                              std::vector<Track>& tracks);
  void watch_events(const std::vector<ObservedBench>& benches);
  client::Outcome follow(std::vector<Track>& tracks);
  client::Outcome take_samples(Track& track);
  bool is_silent(std::uint32_t bench);
  client::Outcome wait_for(Track& track);
  void watch_services();
  void take(Track& track, client::Observation&& sample);

  client::Session& session_;
  Terminal& terminal_;
  const RecordingChoice& choice_;
  std::mutex ended_mutex_;  ///< guards the two below, which a thread of the session fills
  std::map<std::uint32_t, std::string> ended_;  ///< benches whose run is over, and how
  std::map<std::uint32_t, std::chrono::steady_clock::time_point> silent_since_;
  std::unique_ptr<recording::RecordingQueue> queue_;
  recording::Summary summary_;
  std::atomic<std::uint64_t> taken_ = 0;  ///< samples
  std::atomic<double> share_ = 0.0;       ///< of what was asked for; 0 = it has no end
  bool has_begun_ = false;
};

}  // namespace vdrive::tool
