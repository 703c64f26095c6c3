// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "convert.hpp"
#include "mcap_recording.hpp"
#include "output_file.hpp"
#include "recording.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::test {

/// Benches with the given number of axes, numbered from 1, with a tick of 500 us.
std::vector<recording::RecordedBench> benches_of(std::size_t benches, std::size_t axes);

/// Samples in which every published member of every axis has a different value, including the
/// lowest and the highest of its type. The ticks count from 1,000; two are missed before every
/// fifth.
std::vector<client::Observation> samples_of(const recording::RecordedBench& bench,
                                            std::size_t count);

/// Appends the written bytes to a string, which must outlive it.
class StringOutput final : public recording::Output {
 public:
  explicit StringOutput(std::string& bytes) : bytes_(bytes) {}

  void write(std::string_view bytes) override { bytes_.append(bytes); }

 private:
  std::string& bytes_;
};

/// @return the bytes of an MCAP recording.
std::string mcap_of(const std::vector<recording::RecordedBench>& benches,
                    const std::vector<client::Observation>& samples,
                    const std::vector<client::Event>& events = {});

/// @return the text of a recording in a text format.
std::string text_of(recording::Format format, const std::vector<recording::RecordedBench>& benches,
                    const std::vector<client::Observation>& samples);

/// The content of a recording that was read back.
struct Read {
  recording::Contents contents;
  std::vector<client::Observation> samples;
};

/// @throws RecordingError
Read read_back(recording::Format format, const std::string& bytes);

/// Compares the status of axes, including the owner, and the missed samples.
/// @param has_sequence also compares the last sequence number, which text formats do not have
void expect_equal(const std::vector<client::Observation>& read,
                  const std::vector<client::Observation>& written, bool has_sequence);

}  // namespace vdrive::test
