// SPDX-License-Identifier: Apache-2.0
// A recorder that falls behind, and one that cannot write.
#include "output_file.hpp"
#include "recording/sample_recording.hpp"
#include "recording_queue.hpp"
#include "support/temporary_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <thread>

namespace vdrive::test {
namespace {

using namespace recording;
using testing::HasSubstr;

constexpr std::chrono::seconds kDeadline{60};

/// The records of a writer, with a gate in front of it.
struct Records {
  std::mutex mutex;
  std::condition_variable changed;
  bool is_open = true;
  bool is_waiting = false;
  bool fails = false;
  std::vector<client::Observation> samples;
  std::vector<client::Event> events;
  std::optional<Summary> summary;
};

class GatedWriter : public Writer {
 public:
  explicit GatedWriter(Records& records) : records_(records) {}

  void begin(const std::vector<RecordedBench>& /*benches*/) override {}

  void status(const client::Observation& sample) override {
    std::unique_lock lock(records_.mutex);
    records_.is_waiting = true;
    records_.changed.notify_all();
    records_.changed.wait(lock, [this] {
      return records_.is_open;
    });
    if (records_.fails) throw RecordingError("the disk is full");
    records_.samples.push_back(sample);
    records_.changed.notify_all();
  }

  void event(const client::Event& event) override {
    const std::scoped_lock lock(records_.mutex);
    records_.events.push_back(event);
  }

  void parameters(const bridge::ParameterImage& /*image*/) override {}

  void flush(Clock::time_point /*now*/) override {}

  void finish(const Summary& summary) override { records_.summary = summary; }

 private:
  Records& records_;
};

TEST(RecordingQueue, LeavesOutSamplesThatAWriterCannotTakeAndNamesTheirTicks) {
  Records records;
  records.is_open = false;
  const auto benches = benches_of(1, 2);
  const auto samples = samples_of(benches[0], 4);  // ticks 1001 to 1004
  // Room for one sample of two axes only.
  RecordingQueue queue(std::make_unique<GatedWriter>(records), 2);
  queue.push(samples[0]);
  queue.push(samples[1]);
  queue.push(samples[2]);
  {
    std::unique_lock lock(records.mutex);
    records.is_open = true;
    records.changed.notify_all();
    ASSERT_TRUE(records.changed.wait_for(lock, kDeadline, [&] {
      return records.samples.size() == 1;
    }));
  }
  // There is room again after the first sample has been written.
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  auto late = samples[3];
  for (std::uint64_t tick = late.tick; std::chrono::steady_clock::now() < end; ++tick) {
    late.tick = tick;
    queue.push(late);
    const std::scoped_lock lock(records.mutex);
    if (records.samples.size() >= 2) break;
  }
  const Summary summary = queue.finish();
  ASSERT_GE(records.samples.size(), 2U);
  // At least two were omitted, plus those that the loop above pushed too early.
  const std::uint64_t missed = records.samples[1].missed;
  EXPECT_EQ(missed, records.samples[1].tick - 1002);
  EXPECT_GE(missed, 2U);
  ASSERT_FALSE(summary.gaps.missed().kept().empty());
  EXPECT_EQ(summary.gaps.missed().kept()[0].after, 1001U);
  EXPECT_EQ(summary.gaps.missed().kept()[0].before, records.samples[1].tick);
  EXPECT_EQ(summary.samples, records.samples.size());
  ASSERT_TRUE(records.summary);
  EXPECT_EQ(records.summary->gaps.missed().total(), summary.gaps.missed().total());
}

TEST(RecordingQueue, ReportsLeftOutSamplesAtTheEnd) {
  Records records;
  records.is_open = false;
  const auto benches = benches_of(1, 1);
  const auto samples = samples_of(benches[0], 4);
  RecordingQueue queue(std::make_unique<GatedWriter>(records), 1);
  queue.push(samples[0]);
  queue.push(samples[1]);
  queue.push(samples[2]);
  {
    const std::scoped_lock lock(records.mutex);
    records.is_open = true;
  }
  records.changed.notify_all();
  const Summary summary = queue.finish();
  EXPECT_EQ(summary.samples, 1U);
  EXPECT_EQ(summary.gaps.missed().text(4), "after the tick 1001 of bench 1 (2)");
}

TEST(RecordingQueue, ReportsAFailureAndAcceptsNoFurtherSamples) {
  Records records;
  records.fails = true;
  const auto benches = benches_of(1, 1);
  const auto samples = samples_of(benches[0], 1);
  RecordingQueue queue(std::make_unique<GatedWriter>(records));
  queue.push(samples[0]);
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  while (queue.failure().empty() && std::chrono::steady_clock::now() < end)
    std::this_thread::yield();
  EXPECT_EQ(queue.failure(), "the disk is full");
  queue.push(samples[0]);
  queue.push(client::Event{});
  EXPECT_THROW((void)queue.finish(), RecordingError);
  EXPECT_TRUE(records.events.empty());
  EXPECT_FALSE(records.summary);
}

TEST(RecordingQueue, CountsEventsThatDoNotFit) {
  Records records;
  records.is_open = false;
  const auto benches = benches_of(1, 1);
  RecordingQueue queue(std::make_unique<GatedWriter>(records));
  queue.push(samples_of(benches[0], 1)[0]);
  {
    // The queue's thread writes the current records, and takes no more until the lock is released.
    std::unique_lock lock(records.mutex);
    ASSERT_TRUE(records.changed.wait_for(lock, kDeadline, [&] {
      return records.is_waiting;
    }));
  }
  for (std::size_t i = 0; i < RecordingQueue::kMostEvents + 3; ++i) queue.push(client::Event{});
  {
    const std::scoped_lock lock(records.mutex);
    records.is_open = true;
  }
  records.changed.notify_all();
  const Summary summary = queue.finish();
  EXPECT_EQ(summary.events, RecordingQueue::kMostEvents);
  EXPECT_EQ(summary.events_lost, 3U);
  EXPECT_EQ(records.events.size(), RecordingQueue::kMostEvents);
}

TEST(OutputFile, PassesWrittenBytesToTheSystemAtOnce) {
  const TemporaryDirectory directory;
  const std::string path = directory.path() / "x";
  OutputFile file(path);
  file.write("some ");
  file.write("bytes");
  // From here on, killing the process changes nothing.
  std::ifstream stream(path);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(text, "some bytes");
}

TEST(OutputFile, NamesThePlaceAndTheReason) {
  try {
    OutputFile("/no/such/folder/x.mcap");
    FAIL();
  } catch (const RecordingError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'/no/such/folder/x.mcap': No such file"));
  }
  OutputFile full("/dev/full");
  try {
    full.write("x");
    FAIL();
  } catch (const RecordingError& error) {
    EXPECT_THAT(error.what(), HasSubstr("No space left on device"));
  }
}

}  // namespace
}  // namespace vdrive::test
