// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "command.hpp"
#include "terminal.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <map>
#include <ostream>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Axes of one bench whose status stream is recorded.
struct RecordedBench {
  client::BenchInfo info;
  std::vector<client::AxisId> axes;
};

/// Writes the status images of axes to a file, one row an axis and tick, until interrupted or for a
/// while: the stream as it comes, each row with the number of samples that were lost before it.
class Recorder {
 public:
  /// @param names of the axes
  Recorder(client::Session& session, Terminal& terminal, const RecordCommand& command,
           std::map<client::AxisId, std::string> names);

  /// @return failed when the file cannot be written, else how the stream ended; ok when it was
  ///         recorded for as long as requested.
  client::Outcome record(const std::vector<RecordedBench>& benches);

  /// @return whether the file could be opened and the streams were followed.
  [[nodiscard]] bool has_begun() const noexcept { return has_begun_; }

  /// @return samples recorded, one a tick of a bench.
  [[nodiscard]] std::uint64_t samples() const noexcept { return samples_; }

  /// @return samples that were published, or due, and did not arrive.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

 private:
  struct Track;

  client::Outcome follow(std::vector<Track>& tracks);
  client::Outcome take_sample(Track& track);
  void write(const client::Observation& sample);
  [[nodiscard]] std::string csv_row(const client::AxisSnapshot& axis, std::uint64_t missed) const;
  [[nodiscard]] std::string json_row(const client::AxisSnapshot& axis, std::uint64_t missed) const;
  void put(const std::string& line);

  client::Session& session_;
  Terminal& terminal_;
  const RecordCommand& command_;
  std::map<client::AxisId, std::string> names_;
  std::ostream* file_ = nullptr;  ///< none: standard output
  bool has_begun_ = false;
  std::uint64_t samples_ = 0;
  std::uint64_t lost_ = 0;
};

/// @return the header of a CSV recording.
[[nodiscard]] std::string recording_header();

}  // namespace vdrive::tool
