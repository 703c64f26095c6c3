// SPDX-License-Identifier: Apache-2.0
#include "recording/sample_recording.hpp"

#include "text_recording.hpp"
#include "vdrive/dictionary/object.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <sstream>

namespace vdrive::test {

using namespace recording;

std::vector<RecordedBench> benches_of(std::size_t benches, std::size_t axes) {
  std::vector<RecordedBench> all;
  for (std::size_t i = 1; i <= benches; ++i) {
    RecordedBench bench;
    bench.number = static_cast<std::uint32_t>(i);
    bench.period = std::chrono::microseconds(500);
    for (std::size_t axis = 1; axis <= axes; ++axis) {
      const std::string number = std::to_string(axis);
      RecordedAxis& recorded = bench.axes.emplace_back();
      recorded.id = {bench.number, static_cast<std::uint16_t>(axis)};
      recorded.name = "lift \"" + number + "\", left";
      recorded.topic = "lift_" + number;
      if (axis % 3 == 1) recorded.unit = {client::UnitKind::linear, "mm", 1'000.0};
      if (axis % 3 == 2) recorded.unit = client::Unit();  // every third axis has none
    }
    all.push_back(bench);
  }
  return all;
}

std::vector<client::Observation> samples_of(const RecordedBench& bench, std::size_t count) {
  std::vector<client::Observation> samples;
  std::uint64_t tick = 1000;
  std::int64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    client::Observation sample;
    sample.missed = i % 5 == 4 ? 2 : 0;
    tick += 1 + sample.missed;
    sample.tick = tick;
    for (const RecordedAxis& axis : bench.axes) {
      client::AxisSnapshot snapshot;
      snapshot.id = axis.id;
      snapshot.tick = tick;
      for (const StatusMember& member : status_members()) {
        if (!member.is_published) continue;
        const TypeRange range = range_of(member.data_type);
        const std::int64_t own = value++ * 7919;
        const std::int64_t span = range.highest - range.lowest;
        const std::int64_t chosen = own % 11 == 0   ? range.lowest
                                    : own % 11 == 1 ? range.highest
                                                    : range.lowest + own % span;
        member.set(snapshot.status, chosen);
      }
      snapshot.owner_session = i % 3 == 0 ? 0 : 0xFEDC'BA98'7654'3210U - i;
      snapshot.owner_epoch = static_cast<std::uint32_t>(0xFFFF'FFFFU - i);
      snapshot.last_sequence = 0x8000'0000'0000'0000U + i;
      sample.axes.push_back(snapshot);
    }
    samples.push_back(sample);
  }
  return samples;
}

std::string mcap_of(const std::vector<RecordedBench>& benches,
                    const std::vector<client::Observation>& samples,
                    const std::vector<client::Event>& events) {
  std::string bytes;
  McapRecording writer(std::make_unique<StringOutput>(bytes), "test");
  writer.begin(benches);
  Summary summary;
  for (const client::Observation& sample : samples) {
    summary.gaps.note_sample(sample);
    writer.status(sample);
  }
  for (const client::Event& event : events) writer.event(event);
  writer.finish(summary);
  return bytes;
}

std::string text_of(Format format, const std::vector<RecordedBench>& benches,
                    const std::vector<client::Observation>& samples) {
  std::string text;
  TextRecording writer(std::make_unique<StringOutput>(text), format);
  writer.begin(benches);
  for (const client::Observation& sample : samples) writer.status(sample);
  writer.finish({});
  return text;
}

Read read_back(Format format, const std::string& bytes) {
  std::istringstream stream(bytes);
  Read read;
  const SampleHandler keep = [&](const client::Observation& sample) {
    read.samples.push_back(sample);
  };
  read.contents =
      format == Format::mcap ? read_mcap(stream, keep) : read_text(stream, format, keep);
  return read;
}

void expect_equal(const std::vector<client::Observation>& read,
                  const std::vector<client::Observation>& written, bool has_sequence) {
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    SCOPED_TRACE("sample " + std::to_string(i));
    EXPECT_EQ(read[i].tick, written[i].tick);
    EXPECT_EQ(read[i].missed, written[i].missed);
    ASSERT_EQ(read[i].axes.size(), written[i].axes.size());
    for (std::size_t j = 0; j < read[i].axes.size(); ++j) {
      const client::AxisSnapshot& a = read[i].axes[j];
      const client::AxisSnapshot& b = written[i].axes[j];
      EXPECT_EQ(a.id, b.id);
      EXPECT_EQ(a.tick, b.tick);
      for (const StatusMember& member : status_members()) {
        if (!member.is_published) continue;
        EXPECT_EQ(member.value(a.status), member.value(b.status)) << member.name;
      }
      EXPECT_EQ(a.owner_session, b.owner_session);
      EXPECT_EQ(a.owner_epoch, b.owner_epoch);
      if (has_sequence) {
        EXPECT_EQ(a.last_sequence, b.last_sequence);
      }
    }
  }
}

}  // namespace vdrive::test
