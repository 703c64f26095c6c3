// SPDX-License-Identifier: Apache-2.0
// A truncated file is readable up to its end.
#include "mcap_reader.hpp"
#include "recording/sample_recording.hpp"
#include "support/effort.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <sstream>

namespace vdrive::test {
namespace {

using namespace recording;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// A recording with one chunk per `in_chunk` samples.
struct Chunked {
  std::string bytes;
  std::vector<std::size_t> ends;  ///< end of each chunk, including its indexes
};

Chunked chunked(const std::vector<RecordedBench>& benches,
                const std::vector<client::Observation>& samples, std::size_t in_chunk) {
  Chunked file;
  McapRecording writer(std::make_unique<StringOutput>(file.bytes), "test");
  writer.begin(benches);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    writer.status(samples[i]);
    if ((i + 1) % in_chunk != 0) continue;
    // Two seconds later the system has the recorded bytes.
    writer.flush(Writer::Clock::now() + std::chrono::seconds(2));
    file.ends.push_back(file.bytes.size());
  }
  writer.finish({});
  return file;
}

TEST(IncompleteMcap, IsReadUpToItsLastWholeChunk) {
  constexpr std::size_t kInChunk = 3;
  const auto benches = benches_of(1, 2);
  const auto samples = samples_of(benches[0], 30);
  const Chunked file = chunked(benches, samples, kInChunk);
  ASSERT_EQ(file.ends.size(), 10U);
  // Every length from the complete magic on; the prime step hits each field of a chunk in some
  // chunk.
  const auto step = number_of<std::size_t>({.usual = 23, .full = 1, .nightly = 1});
  for (std::size_t size = kMcapMagic.size(); size < file.bytes.size(); size += step) {
    SCOPED_TRACE("cut at " + std::to_string(size));
    const Read read = read_back(Format::mcap, file.bytes.substr(0, size));
    EXPECT_THAT(read.contents.cut, HasSubstr("at byte " + std::to_string(size)));
    // The complete chunks are read, and a chunk that lacks only its indexes.
    const auto whole =
        static_cast<std::size_t>(std::ranges::count_if(file.ends, [size](std::size_t end) {
          return end <= size;
        }));
    ASSERT_GE(read.samples.size(), whole * kInChunk);
    ASSERT_LE(read.samples.size(), (whole + 1) * kInChunk);
    ASSERT_EQ(read.samples.size() % kInChunk, 0U);
    const std::vector<client::Observation> expected(
        samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(read.samples.size()));
    expect_equal(read.samples, expected, true);
    if (testing::Test::HasFailure()) return;
  }
  const Read whole = read_back(Format::mcap, file.bytes);
  EXPECT_THAT(whole.contents.cut, IsEmpty());
  expect_equal(whole.samples, samples, true);
}

TEST(IncompleteMcap, NeverGivesOtherValuesAfterADamagedByte) {
  const auto benches = benches_of(1, 1);
  const auto samples = samples_of(benches[0], 6);
  const Chunked file = chunked(benches, samples, 2);
  const std::uint32_t seed = std::random_device()();
  std::mt19937 random(seed);
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (int i = 0; i < 300; ++i) {
    std::string damaged = file.bytes;
    const std::size_t place = random() % file.ends.back();
    damaged[place] = static_cast<char>(damaged[place] ^ (1 << random() % 8));
    SCOPED_TRACE("byte " + std::to_string(place));
    // A record that claims to extend beyond the file counts as cut off; other damage is refused.
    try {
      const Read read = read_back(Format::mcap, damaged);
      ASSERT_THAT(read.contents.cut, Not(IsEmpty()));
      ASSERT_LE(read.samples.size(), samples.size());
    } catch (const RecordingError& error) {
      ASSERT_THAT(std::string(error.what()), Not(IsEmpty()));
    }
  }
}

}  // namespace
}  // namespace vdrive::test
