// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mcap_writer.hpp"
#include "recording.hpp"

#include <cstddef>
#include <istream>
#include <map>
#include <memory>
#include <string>

namespace vdrive::recording {

/// Records to MCAP: status, events and parameters in CDR with the schemas of the gateway, in drive
/// time. A bench with few axes has one topic per axis, a bench with many axes one topic for all.
class McapRecording : public Writer {
 public:
  /// The most axes of a bench that get a topic each.
  static constexpr std::size_t kMostTopics = 16;

  /// @param version of the program, as information for readers
  McapRecording(std::unique_ptr<Output> output, const std::string& version);

  void begin(const std::vector<RecordedBench>& benches) override;
  void status(const client::Observation& sample) override;
  void event(const client::Event& event) override;
  void parameters(const bridge::ParameterImage& image) override;
  void flush(Clock::time_point now) override;
  void finish(const Summary& summary) override;

 private:
  struct Channels {
    std::uint64_t period = 0;                           ///< of a tick [ns]
    std::string topic{};                                ///< such as "bench1"
    std::map<std::uint16_t, std::string> names{};       ///< of the axes, in topics
    std::map<std::uint16_t, std::uint16_t> status{};    ///< by axis; 0 = all axes
    std::map<std::uint16_t, std::uint16_t> readings{};  ///< of parameters; by axis, 0 = all axes
    std::uint16_t events = 0;
  };

  void add_bench(const RecordedBench& bench);
  void end_chunk();

  McapWriter file_;
  std::uint16_t axis_status_ = 0;  ///< numbers of the schemas
  std::uint16_t bench_status_ = 0;
  std::uint16_t axis_parameters_ = 0;
  std::uint16_t log_ = 0;
  std::map<std::uint32_t, Channels> benches_;
  TextMap gaps_;  ///< of the samples in the chunk being filled
  Clock::time_point chunk_began_{};
};

/// Reads the status of an MCAP recording made by this program, or by Foxglove from the topics of
/// the gateway.
/// @param file positioned at its beginning
/// @throws RecordingError without the name of the file
[[nodiscard]] Contents read_mcap(std::istream& file, const SampleHandler& handler);

}  // namespace vdrive::recording
