// SPDX-License-Identifier: Apache-2.0
// MCAP recordings: written files are read back; damaged and foreign files are refused.
#include "mcap_reader.hpp"
#include "mcap_writer.hpp"
#include "recording/sample_recording.hpp"
#include "status_layout.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <zstd.h>

#include <cstring>
#include <map>
#include <memory>
#include <sstream>

namespace vdrive::test {
namespace {

using namespace recording;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

/// The number of records of each kind in the file. The records inside chunks are counted; the
/// chunks are not.
std::map<Opcode, std::size_t> kinds_of(const std::string& bytes) {
  std::istringstream stream(bytes);
  McapReader reader(stream);
  std::map<Opcode, std::size_t> kinds;
  while (const auto record = reader.next()) ++kinds[record->opcode];
  EXPECT_THAT(reader.cut(), IsEmpty());
  return kinds;
}

/// The bodies of the records of a kind.
std::vector<std::string> bodies_of(const std::string& bytes, Opcode opcode) {
  std::istringstream stream(bytes);
  McapReader reader(stream);
  std::vector<std::string> bodies;
  while (const auto record = reader.next()) {
    if (record->opcode == opcode) bodies.emplace_back(record->body);
  }
  return bodies;
}

TEST(Mcap, AnEmptyFileBeginsWithTheBytesOfTheStandard) {
  std::string bytes;
  const McapWriter writer(std::make_unique<StringOutput>(bytes), "me");
  // The magic; opcode 1, a body of 4 + 0 + 4 + 2 bytes; an empty profile; the library.
  const std::string expected("\x89MCAP0\r\n\x01\x0A\0\0\0\0\0\0\0\0\0\0\0\x02\0\0\0me", 27);
  EXPECT_EQ(bytes, expected);
}

TEST(Mcap, ARecordHasOpcodeLengthAndBody) {
  std::string bytes;
  RecordBuilder(bytes, Opcode::channel)
      .put(std::uint16_t{1})
      .put(std::string_view("ab"))
      .put(TextMap{{"k", "v"}});
  // Body: 2 + (4 + 2) + 4 + (4 + 1 + 4 + 1) = 22 bytes.
  EXPECT_EQ(bytes, std::string("\x04\x16\0\0\0\0\0\0\0"
                               "\x01\0"
                               "\x02\0\0\0ab"
                               "\x0A\0\0\0\x01\0\0\0k\x01\0\0\0v",
                               31));
}

TEST(Mcap, TheChecksumIsThatOfTheStandard) {
  // The check value of CRC-32 (ISO-HDLC).
  EXPECT_EQ(crc_of("123456789"), 0xCBF43926U);
  EXPECT_EQ(crc_of("6789", crc_of("12345")), 0xCBF43926U);
}

class McapOfAxes : public testing::TestWithParam<std::size_t> {};

TEST_P(McapOfAxes, IsReadBackUnchanged) {
  const auto benches = benches_of(1, GetParam());
  const auto samples = samples_of(benches[0], 40);
  const Read read = read_back(Format::mcap, mcap_of(benches, samples));
  expect_equal(read.samples, samples, true);
  EXPECT_THAT(read.contents.cut, IsEmpty());
  ASSERT_EQ(read.contents.benches.size(), 1U);
  EXPECT_EQ(read.contents.benches[0].period, std::chrono::microseconds(500));
  EXPECT_EQ(names_of(read.contents.benches), names_of(benches));
}

// One topic per axis up to 16 axes, one topic for all from 17 on.
INSTANTIATE_TEST_SUITE_P(Mcap, McapOfAxes, testing::Values(1, 16, 17, 40));

TEST(Mcap, OfSeveralBenchesSeparatesTheirSamples) {
  const auto benches = benches_of(2, 2);
  std::vector<client::Observation> samples;
  const auto first = samples_of(benches[0], 6);
  const auto second = samples_of(benches[1], 6);
  for (std::size_t i = 0; i < 6; ++i) {
    samples.push_back(first[i]);
    samples.push_back(second[i]);
  }
  expect_equal(read_back(Format::mcap, mcap_of(benches, samples)).samples, samples, true);
}

TEST(Mcap, HasIndexesStatisticsAndMetadata) {
  const auto benches = benches_of(1, 2);
  const client::Event event{.bench = 1, .axis = 2, .tick = 1003, .text = "axis 2: halted"};
  const auto kinds = kinds_of(mcap_of(benches, samples_of(benches[0], 10), {event}));
  // 10 samples of 2 axes and the event; the chunk contains the status of each axis and the events.
  EXPECT_EQ(kinds.at(Opcode::message), 21U);
  EXPECT_EQ(kinds.at(Opcode::message_index), 3U);
  EXPECT_EQ(kinds.at(Opcode::chunk_index), 1U);
  EXPECT_EQ(kinds.at(Opcode::statistics), 1U);
  // Bench, gaps (before two samples) and summary.
  EXPECT_EQ(kinds.at(Opcode::metadata), 3U);
  EXPECT_EQ(kinds.at(Opcode::metadata_index), 3U);
  // Schemas, channels, statistics, metadata, chunks.
  EXPECT_EQ(kinds.at(Opcode::summary_offset), 5U);
  EXPECT_EQ(kinds.at(Opcode::data_end), 1U);
  EXPECT_EQ(kinds.at(Opcode::footer), 1U);
  // Status, bench status, parameters, log: in the data and in the summary.
  EXPECT_EQ(kinds.at(Opcode::schema), 8U);
  // Status and parameters of each axis, events: likewise.
  EXPECT_EQ(kinds.at(Opcode::channel), 10U);
}

TEST(Mcap, IndexesPointToTheirMessages) {
  const auto benches = benches_of(1, 1);
  const std::string bytes = mcap_of(benches, samples_of(benches[0], 3));
  // The chunk's records are uncompressed messages of equal length, so the offsets are multiples of
  // that length.
  const auto messages = bodies_of(bytes, Opcode::message);
  ASSERT_EQ(messages.size(), 3U);
  const auto indexes = bodies_of(bytes, Opcode::message_index);
  ASSERT_EQ(indexes.size(), 1U);
  BodyReader index(indexes[0], "index");
  (void)index.get<std::uint16_t>();
  ASSERT_EQ(index.get<std::uint32_t>(), 3U * 16U);
  for (std::size_t i = 0; i < 3; ++i) {
    // Ticks 1001, 1002, 1003 of 500 us.
    EXPECT_EQ(index.get<std::uint64_t>(), (1001 + i) * 500'000);
    EXPECT_EQ(index.get<std::uint64_t>(), i * (kMcapHead + messages[0].size()));
  }
  const auto chunks = bodies_of(bytes, Opcode::chunk_index);
  ASSERT_EQ(chunks.size(), 1U);
  BodyReader chunk(chunks[0], "chunk index");
  EXPECT_EQ(chunk.get<std::uint64_t>(), 1001U * 500'000);
  EXPECT_EQ(chunk.get<std::uint64_t>(), 1003U * 500'000);
  const auto offset = chunk.get<std::uint64_t>();
  EXPECT_EQ(bytes[offset], static_cast<char>(Opcode::chunk));
  const auto length = chunk.get<std::uint64_t>();
  ASSERT_EQ(chunk.get<std::uint32_t>(), 10U);
  (void)chunk.get<std::uint16_t>();
  const auto place = chunk.get<std::uint64_t>();
  EXPECT_EQ(place, offset + length);
  EXPECT_EQ(bytes[place], static_cast<char>(Opcode::message_index));
}

TEST(Mcap, EventsOfABenchAreInItsTopicAndAreCounted) {
  const auto benches = benches_of(1, 1);
  const client::Event own{.bench = 1, .axis = 1, .tick = 7, .text = "fault"};
  const client::Event strange{.bench = 9, .axis = 1, .tick = 7, .text = "of another bench"};
  const std::string bytes = mcap_of(benches, samples_of(benches[0], 1), {own, own, strange});
  EXPECT_EQ(read_back(Format::mcap, bytes).contents.events, 2U);
  const auto messages = bodies_of(bytes, Opcode::message);
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_THAT(messages[1], AllOf(HasSubstr("fault"), HasSubstr("bench1/lift_1")));
}

/// Writes chunks that differ from those of our recorder.
class Foreign {
 public:
  Foreign() { bytes_.append(kMcapMagic); }

  RecordBuilder record(Opcode opcode) { return {bytes_, opcode}; }

  void chunk(std::string_view compression, std::string_view records, std::uint64_t size,
             std::uint32_t crc = 0) {
    record(Opcode::chunk)
        .put(std::uint64_t{0})
        .put(std::uint64_t{0})
        .put(size)
        .put(crc)
        .put(compression)
        .put(std::uint64_t{records.size()})
        .put_raw(records);
  }

  void end() {
    record(Opcode::data_end).put(std::uint32_t{0});
    record(Opcode::footer).put(std::uint64_t{0}).put(std::uint64_t{0}).put(std::uint32_t{0});
    bytes_.append(kMcapMagic);
  }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

void add_topic(Foreign& file, std::string_view schema, std::string_view text,
               std::string_view topic, std::string_view encoding = "cdr") {
  file.record(Opcode::header).put(std::string_view("ros2")).put(std::string_view("other"));
  file.record(Opcode::schema)
      .put(std::uint16_t{5})
      .put(schema)
      .put(std::string_view("ros2msg"))
      .put(text);
  file.record(Opcode::channel)
      .put(std::uint16_t{8})
      .put(std::uint16_t{5})
      .put(topic)
      .put(encoding)
      .put(TextMap{});
}

/// @return the error of reading the bytes.
std::string refusal_of(const std::string& bytes) {
  try {
    (void)read_back(Format::mcap, bytes);
  } catch (const RecordingError& error) {
    return error.what();
  }
  return "";
}

TEST(Mcap, OfAnotherProgramIsRefusedWithItsTopics) {
  Foreign file;
  add_topic(file, "sensor_msgs/msg/Imu", "float64 x\n", "/imu");
  file.end();
  EXPECT_THAT(refusal_of(file.bytes()),
              AllOf(HasSubstr("no topic with the status of a bench"), HasSubstr("'/imu'")));
}

TEST(Mcap, OfFoxgloveIsReadWithoutMetadataOfVdrive) {
  Foreign file;
  const auto schema = bridge::axis_status_schema();
  add_topic(file, schema.name, schema.text, "/bench3/lift/status");
  client::AxisSnapshot axis;
  axis.id = {3, 2};
  axis.tick = 9;
  axis.owner_session = 4;
  std::string records;
  RecordBuilder(records, Opcode::message)
      .put(std::uint16_t{8})
      .put(std::uint32_t{0})
      .put(std::uint64_t{0})
      .put(std::uint64_t{0})
      .put_raw(bridge::encode_axis_status(axis, 0));
  file.chunk("", records, records.size());
  file.end();
  const Read read = read_back(Format::mcap, file.bytes());
  expect_equal(read.samples, {{.tick = 9, .missed = 0, .axes = {axis}}}, true);
  EXPECT_EQ(read.contents.benches.at(0).axes.at(0).name, "lift");
}

/// A status message of an axis on channel 8.
std::string status_record(const client::AxisSnapshot& axis) {
  std::string record;
  RecordBuilder(record, Opcode::message)
      .put(std::uint16_t{8})
      .put(std::uint32_t{0})
      .put(std::uint64_t{0})
      .put(std::uint64_t{0})
      .put_raw(bridge::encode_axis_status(axis, 0));
  return record;
}

std::string status_of_tick(std::uint64_t tick, std::uint16_t axis = 1) {
  client::AxisSnapshot snapshot;
  snapshot.id = {1, axis};
  snapshot.tick = tick;
  return status_record(snapshot);
}

/// A file with one chunk per text.
std::string file_with_chunks(const std::vector<std::string>& chunks) {
  Foreign file;
  const auto schema = bridge::axis_status_schema();
  add_topic(file, schema.name, schema.text, "/bench1/x/status");
  for (const std::string& records : chunks) file.chunk("", records, records.size());
  file.end();
  return file.bytes();
}

TEST(Mcap, WithARepeatedChunkIsRefusedWithItsPlace) {
  const std::string chunk = status_of_tick(5) + status_of_tick(6);
  EXPECT_THAT(refusal_of(file_with_chunks({chunk, chunk})),
              AllOf(HasSubstr("the message record in the chunk at byte"),
                    HasSubstr("the tick 5 of the axis 1.1 follows the tick 6 of its bench")));
  EXPECT_THAT(refusal_of(file_with_chunks({status_of_tick(5), status_of_tick(5)})),
              HasSubstr("the axis 1.1 has the tick 5 twice"));
}

TEST(Mcap, ThatEndsBetweenTwoAxesOfATickIsReadUpToTheTickBefore) {
  const std::string whole = status_of_tick(5, 1) + status_of_tick(5, 2);
  const Read read = read_back(Format::mcap, file_with_chunks({whole + status_of_tick(6, 1)}));
  EXPECT_EQ(read.samples.size(), 1U);
  EXPECT_EQ(read.contents.cut, "the tick 6 of bench 1 has 1 of 2 axes");
}

TEST(Mcap, OfAnAxisWithTheNumber0IsRefused) {
  auto samples = samples_of(benches_of(1, 1)[0], 1);
  Foreign file;
  const auto schema = bridge::axis_status_schema();
  add_topic(file, schema.name, schema.text, "/bench1/x/status");
  samples[0].axes[0].id.axis = 0;
  std::string records;
  RecordBuilder(records, Opcode::message)
      .put(std::uint16_t{8})
      .put(std::uint32_t{0})
      .put(std::uint64_t{0})
      .put(std::uint64_t{0})
      .put_raw(bridge::encode_axis_status(samples[0].axes[0], 0));
  file.chunk("", records, records.size());
  file.end();
  EXPECT_THAT(refusal_of(file.bytes()), HasSubstr("the number 0"));
}

TEST(Mcap, OfAnotherVersionIsReadByItsSchema) {
  // Fields in another order, an unknown one, and no others.
  const StatusLayout layout(
      "# a comment\nuint8 KIND=3\nstring note\nint16 torque_actual_value  # of rated\n"
      "uint64 tick\nfloat64[] unknown\nuint16 axis\n====\nMSG: x\nint8 y\n");
  // note "a" takes 2 bytes after its length: up to 6; torque -2 at 6; tick 5 at 8; two doubles:
  // count at 16, values at 24 and 32; axis at 40.
  std::string bytes("\0\1\0\0\2\0\0\0a\0\xFE\xFF\5\0\0\0\0\0\0\0\2\0\0\0\0\0\0\0", 28);
  bytes.append(16, '\x7F').append("\7\0", 2);
  const auto axes = layout.decode(bytes);
  ASSERT_EQ(axes.size(), 1U);
  EXPECT_EQ(axes[0].tick, 5U);
  EXPECT_EQ(axes[0].id.axis, 7U);
  EXPECT_EQ(axes[0].status.torque_actual_value, -2);
  EXPECT_EQ(axes[0].status.position_demand_value, 0);
}

TEST(Mcap, OfTheStatusInAnotherEncodingIsRefused) {
  Foreign file;
  add_topic(file, "vdrive_msgs/msg/AxisStatus", "uint64 tick\n", "/bench1/x/status", "json");
  EXPECT_THAT(refusal_of(file.bytes()), AllOf(HasSubstr("'json'"), HasSubstr("/bench1/x/status")));
}

TEST(Mcap, WithAFieldOfATypeThatIsNotKnownIsRefused) {
  Foreign file;
  add_topic(file, "vdrive_msgs/msg/AxisStatus", "uint64 tick\nuint8[4] raw\n", "/bench1/x/status");
  EXPECT_THAT(refusal_of(file.bytes()), AllOf(HasSubstr("'raw'"), HasSubstr("'uint8[4]'")));
}

TEST(Mcap, InAnotherCompressionIsRefusedWithItsPlace) {
  Foreign file;
  file.chunk("lz4", "xxxx", 100);
  // After the magic of 8 bytes.
  EXPECT_THAT(refusal_of(file.bytes()), AllOf(HasSubstr("'lz4'"), HasSubstr("at byte 8")));
}

TEST(Mcap, WithADamagedChunkIsRefused) {
  Foreign wrong_sum;
  wrong_sum.chunk("", "\x0D\0\0\0\0\0\0\0\0", 9, 77);
  EXPECT_THAT(refusal_of(wrong_sum.bytes()), HasSubstr("a wrong checksum"));
  Foreign no_zstd;
  no_zstd.chunk("zstd", "certainly not", 20);
  EXPECT_THAT(refusal_of(no_zstd.bytes()), HasSubstr("cannot be decompressed"));
  Foreign huge;
  huge.chunk("zstd", "x", std::uint64_t{1} << 40U);
  EXPECT_THAT(refusal_of(huge.bytes()), HasSubstr("claims 1099511627776 bytes"));
}

TEST(Mcap, WithAChunkOfAFewKilobytesThatBecomesHundredsOfMegabytesIsRefusedWithTheLimit) {
  const std::string zeros(std::size_t{250} << 20U, '\0');
  std::string small(ZSTD_compressBound(zeros.size()), '\0');
  small.resize(ZSTD_compress(small.data(), small.size(), zeros.data(), zeros.size(), 1));
  ASSERT_LT(small.size(), 40'000U);
  Foreign file;
  file.chunk("zstd", small, zeros.size());
  EXPECT_THAT(refusal_of(file.bytes()),
              AllOf(HasSubstr("claims 262144000 bytes"), HasSubstr("at most 67108864 are read")));
}

TEST(Mcap, WithAChangedByteInItsDataIsRefused) {
  const auto benches = benches_of(1, 1);
  const std::string whole = mcap_of(benches, samples_of(benches[0], 3));
  // In the name of an axis, in the metadata before the first chunk: no chunk's checksum covers it,
  // but that of the data does.
  std::string damaged = whole;
  damaged[damaged.find("lift")] = 'L';
  EXPECT_THAT(refusal_of(damaged), HasSubstr("a wrong checksum"));
  // In the summary.
  damaged = whole;
  damaged[damaged.rfind("lift")] = 'L';
  EXPECT_THAT(refusal_of(damaged), HasSubstr("summary"));
}

TEST(Mcap, WithAnotherFileFormatIsRefused) {
  EXPECT_THAT(refusal_of("axis,name,tick\n"), HasSubstr("not an MCAP file"));
  EXPECT_THAT(refusal_of(""), HasSubstr("not an MCAP file"));
}

TEST(Mcap, AMessageOfAnUnknownChannelIsRefused) {
  Foreign file;
  file.record(Opcode::message).put(std::uint16_t{3});
  EXPECT_THAT(refusal_of(file.bytes()), HasSubstr("channel 3"));
}

TEST(Mcap, ParametersHaveEveryObjectAndMarkRefusedOnes) {
  bridge::ParameterImage image{.axis = {1, 1}, .tick = 4, .objects = {}};
  for (const ObjectDescription& object : kObjectTable) {
    image.objects.push_back({.object = object.address, .code = AbortCode::none, .value = 0});
  }
  image.objects[0].value = 0x01020304;  // 1000h, the first of the table
  image.objects[2].code = AbortCode::object_does_not_exist;
  const std::string bytes = bridge::encode_axis_parameters(image, 2'000'000'000);
  // Header; 2 s; tick 4; axis 1, two bytes of padding; 1000h.
  EXPECT_THAT(bytes,
              testing::StartsWith(std::string("\0\1\0\0\2\0\0\0\0\0\0\0\4\0\0\0\0\0\0\0\1\0\0\0"
                                              "\4\3\2\1",
                                              28)));
  // The list at the end: one object.
  std::uint32_t last = 0;
  std::memcpy(&last, bytes.data() + bytes.size() - 4, 4);
  EXPECT_EQ(last, kObjectTable[2].address.index * 256U + kObjectTable[2].address.subindex);
  std::memcpy(&last, bytes.data() + bytes.size() - 8, 4);
  EXPECT_EQ(last, 1U);
  const auto schema = bridge::axis_parameters_schema();
  for (const ObjectDescription& object : kObjectTable) {
    EXPECT_THAT(schema.text, HasSubstr(" " + std::string(object.variable_name) + "\n"));
  }
}

}  // namespace
}  // namespace vdrive::test
