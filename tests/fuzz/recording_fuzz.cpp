// SPDX-License-Identifier: Apache-2.0
//
// Any bytes are either a recording or refused with a sentence, and the content of an MCAP or text
// recording can be written and is the same when read again.
#include "fuzz/support/bytes.hpp"
#include "mcap_recording.hpp"
#include "recording.hpp"
#include "text_recording.hpp"

#include <cstdint>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace vdrive;
using namespace vdrive::recording;
using vdrive::test::demand;

struct Recorded {
  Contents contents;
  std::vector<client::Observation> samples;
};

Recorded read(Format format, const std::string& bytes) {
  std::istringstream stream(bytes);
  Recorded recorded;
  const SampleHandler keep = [&](const client::Observation& sample) {
    demand(!sample.axes.empty(), "a sample has an axis");
    recorded.samples.push_back(sample);
  };
  recorded.contents =
      format == Format::mcap ? read_mcap(stream, keep) : read_text(stream, format, keep);
  return recorded;
}

class StringOutput final : public Output {
 public:
  explicit StringOutput(std::string& bytes) : bytes_(bytes) {}

  void write(std::string_view bytes) override { bytes_.append(bytes); }

 private:
  std::string& bytes_;
};

void check_written(Recorded& recorded) {
  for (RecordedBench& bench : recorded.contents.benches) {
    for (RecordedAxis& axis : bench.axes) axis.topic = "axis" + std::to_string(axis.id.axis);
  }
  std::string bytes;
  McapRecording writer(std::make_unique<StringOutput>(bytes), "fuzz");
  writer.begin(recorded.contents.benches);
  for (const client::Observation& sample : recorded.samples) writer.status(sample);
  writer.finish({});
  const Recorded again = read(Format::mcap, bytes);
  demand(again.contents.cut.empty(), "what was written is whole");
  demand(again.contents.rows == recorded.contents.rows, "no row is lost");
}

void check(Format format, const std::string& bytes) {
  try {
    Recorded recorded = read(format, bytes);
    check_written(recorded);
  } catch (const RecordingError& error) {
    const std::string_view text = error.what();
    demand(!text.empty() && text.size() < 4000, "a refusal is a sentence");
    demand(text.find('\n') == std::string_view::npos, "on one line");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(data, data + size);
  check(Format::mcap, bytes);
  check(Format::csv, bytes);
  check(Format::json_lines, bytes);
  return 0;
}
