// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output_file.hpp"
#include "recording.hpp"

#include <istream>
#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace vdrive::recording {

/// Records the status as text: CSV or JSON lines. Events and parameters are not recorded.
class TextRecording : public Writer {
 public:
  /// @param format csv or json_lines
  /// @param output receives complete lines, several at a time
  TextRecording(std::unique_ptr<Output> output, Format format);

  void begin(const std::vector<RecordedBench>& benches) override;
  void status(const client::Observation& sample) override;
  void event(const client::Event& event) override;
  void parameters(const bridge::ParameterImage& image) override;
  void flush(Clock::time_point now) override;
  void finish(const Summary& summary) override;

 private:
  [[nodiscard]] std::string csv_row(const client::AxisSnapshot& axis, std::uint64_t missed) const;
  [[nodiscard]] std::string json_row(const client::AxisSnapshot& axis, std::uint64_t missed) const;

  void put(std::string_view line);
  void write();

  std::unique_ptr<Output> output_;
  Format format_;
  std::string lines_;  ///< not written yet
  std::map<client::AxisId, RecordedAxis> axes_;
};

/// @return the first line of a CSV recording.
[[nodiscard]] std::string csv_header();

/// Reads a text recording. Consecutive rows with the same bench and tick form one sample.
/// @param file positioned at its beginning
/// @param format csv or json_lines
/// @throws RecordingError without the name of the file, but with the line
[[nodiscard]] Contents read_text(std::istream& file, Format format, const SampleHandler& handler);

}  // namespace vdrive::recording
