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

/// The contents and length of a recording.
struct RecordingChoice {
  std::string file{};  ///< - = standard output
  recording::Format format = recording::Format::csv;
  std::optional<Duration> duration{};             ///< drive time; none = until interrupted
  std::uint64_t count = 0;                        ///< samples of each bench; 0 = no limit
  Duration lost_after = std::chrono::minutes(1);  ///< wall time without a sample after which the
                                                  ///< recording ends
};

/// The axes of one bench to record.
struct ObservedBench {
  client::BenchInfo info;
  std::vector<client::Axis> axes;
};

/// Records the status images of axes, one sample per bench and tick, until interrupted or for a
/// given time: the stream as received, with the number of lost samples. An MCAP file also gets
/// every object of the axes as of the start, and the events of the benches and axes.
///
/// The recorder waits indefinitely for a bench whose time stands still, and up to
/// RecordingChoice::lost_after for one that sends nothing. The end or restart of a service ends the
/// recording.
class Recorder {
 public:
  Recorder(client::Session& session, Terminal& terminal, const RecordingChoice& choice);

  /// @return failed when the file cannot be written, otherwise how the stream ended; ok if the
  ///         requested length was recorded.
  client::Outcome record(const std::vector<ObservedBench>& benches);

  /// @return the progress, such as "recorded 4812 samples, 20 %". Thread-safe.
  [[nodiscard]] std::string progress() const;

  /// @return whether the file was opened and the streams were followed.
  [[nodiscard]] bool has_begun() const noexcept { return has_begun_; }

  /// A summary of the recording.
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
  std::mutex ended_mutex_;  ///< guards the two members below, which a thread of the session writes
  std::map<std::uint32_t, std::string> ended_;  ///< benches whose run has ended, with the reason
  std::map<std::uint32_t, std::chrono::steady_clock::time_point> silent_since_;
  std::unique_ptr<recording::RecordingQueue> queue_;
  recording::Summary summary_;
  std::atomic<std::uint64_t> taken_ = 0;  ///< samples
  std::atomic<double> share_ = 0.0;       ///< of the requested length; 0 = no limit
  bool has_begun_ = false;
};

}  // namespace vdrive::tool
