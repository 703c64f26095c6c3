// SPDX-License-Identifier: Apache-2.0
#include "mcap_writer.hpp"

#include "recording.hpp"

#include <zstd.h>

#include <algorithm>
#include <iterator>

namespace vdrive::recording {
namespace {

// The fastest of the usual levels: a recorder shares the machine with the system it records.
constexpr int kLevel = 1;
constexpr std::string_view kZstd = "zstd";

}  // namespace

struct McapWriter::Compressor {
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context{ZSTD_createCCtx(), &ZSTD_freeCCtx};
  std::string out{};

  std::string_view operator()(std::string_view bytes) {
    out.resize(ZSTD_compressBound(bytes.size()));
    const std::size_t size = ZSTD_compressCCtx(context.get(), out.data(), out.size(), bytes.data(),
                                               bytes.size(), kLevel);
    if (ZSTD_isError(size) != 0U) {
      throw RecordingError(std::string("cannot compress: ") + ZSTD_getErrorName(size));
    }
    return std::string_view(out).substr(0, size);
  }
};

void McapWriter::TimeRange::add(std::uint64_t time, bool is_first) noexcept {
  first = is_first ? time : std::min(first, time);
  last = is_first ? time : std::max(last, time);
}

McapWriter::McapWriter(std::unique_ptr<Output> output, std::string_view library)
    : output_(std::move(output)), compressor_(std::make_unique<Compressor>()) {
  std::string begin(kMcapMagic);
  RecordBuilder(begin, Opcode::header).put(std::string_view()).put(library);
  write(begin);
}

McapWriter::~McapWriter() = default;

void McapWriter::write(std::string_view bytes) {
  output_->write(bytes);
  offset_ += bytes.size();
  crc_ = crc_of(bytes, crc_);
}

std::uint16_t McapWriter::add_schema(const bridge::MessageSchema& schema) {
  const auto id = static_cast<std::uint16_t>(++schema_count_);  // 0 = none
  const std::size_t start = schemas_.size();
  RecordBuilder(schemas_, Opcode::schema)
      .put(id)
      .put(std::string_view(schema.name))
      .put(std::string_view("ros2msg"))
      .put(std::string_view(schema.text));
  write(std::string_view(schemas_).substr(start));
  return id;
}

std::uint16_t McapWriter::add_channel(std::string_view topic, std::uint16_t schema,
                                      const TextMap& metadata) {
  constexpr std::size_t kMost = 0xFFFF;
  if (sequences_.size() >= kMost) throw RecordingError("a file has at most 65535 topics");
  const auto id = static_cast<std::uint16_t>(sequences_.size());
  const std::size_t start = channels_.size();
  RecordBuilder(channels_, Opcode::channel)
      .put(id)
      .put(schema)
      .put(topic)
      .put(std::string_view("cdr"))
      .put(metadata);
  write(std::string_view(channels_).substr(start));
  sequences_.push_back(0);
  in_chunk_.emplace_back();
  return id;
}

void McapWriter::add_metadata(std::string_view name, const TextMap& metadata) {
  buffer_.clear();
  RecordBuilder(buffer_, Opcode::metadata).put(name).put(metadata);
  metadata_.push_back({.name = std::string(name), .offset = offset_, .length = buffer_.size()});
  write(buffer_);
}

void McapWriter::add_message(std::uint16_t channel, std::uint64_t time, std::string_view bytes) {
  chunk_range_.add(time, chunk_.empty());
  range_.add(time, message_count_ == 0);
  std::vector<Place>& places = in_chunk_[channel];
  if (places.empty()) used_in_chunk_.push_back(channel);
  places.push_back({.time = time, .offset = chunk_.size()});
  RecordBuilder(chunk_, Opcode::message)
      .put(channel)
      .put(++sequences_[channel])
      .put(time)
      .put(time)
      .put_raw(bytes);
  ++message_count_;
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  ChunkPlace place{.range = chunk_range_, .offset = offset_, .uncompressed = chunk_.size()};
  write_chunk(place);
  write_indexes(place);
  chunks_.push_back(std::move(place));
  chunk_.clear();
}

void McapWriter::write_chunk(ChunkPlace& place) {
  const std::string_view compressed = (*compressor_)(chunk_);
  place.compressed = compressed.size();
  buffer_.clear();
  RecordBuilder(buffer_, Opcode::chunk)
      .put(place.range.first)
      .put(place.range.last)
      .put(place.uncompressed)
      .put(crc_of(chunk_))
      .put(kZstd)
      .put(place.compressed)
      .put_raw(compressed);
  place.length = buffer_.size();
}

/// The indexes are written together with their chunk: a truncated file has both or neither.
void McapWriter::write_indexes(ChunkPlace& place) {
  constexpr std::size_t kEntry = 16;
  std::ranges::sort(used_in_chunk_);
  for (const std::uint16_t channel : used_in_chunk_) {
    std::vector<Place>& entries = in_chunk_[channel];
    std::ranges::stable_sort(entries, {}, &Place::time);
    place.indexes[channel] = place.offset + buffer_.size();
    RecordBuilder record(buffer_, Opcode::message_index);
    record.put(channel).put(static_cast<std::uint32_t>(entries.size() * kEntry));
    for (const Place& entry : entries) record.put(entry.time).put(entry.offset);
    entries.clear();
  }
  used_in_chunk_.clear();
  place.index_length = buffer_.size() - place.length;
  write(buffer_);
}

void McapWriter::append_statistics(std::string& out) const {
  constexpr std::size_t kEntry = 10;
  RecordBuilder record(out, Opcode::statistics);
  record.put(message_count_)
      .put(schema_count_)
      .put(static_cast<std::uint32_t>(sequences_.size()))
      .put(std::uint32_t{0})  // attachments
      .put(static_cast<std::uint32_t>(metadata_.size()))
      .put(static_cast<std::uint32_t>(chunks_.size()))
      .put(range_.first)
      .put(range_.last);
  const auto used =
      sequences_.size() - static_cast<std::size_t>(std::ranges::count(sequences_, 0U));
  record.put(static_cast<std::uint32_t>(used * kEntry));
  for (std::size_t channel = 0; channel < sequences_.size(); ++channel) {
    if (sequences_[channel] == 0) continue;
    record.put(static_cast<std::uint16_t>(channel)).put(std::uint64_t{sequences_[channel]});
  }
}

void McapWriter::append_chunk_indexes(std::string& out) const {
  constexpr std::size_t kEntry = 10;
  for (const ChunkPlace& chunk : chunks_) {
    RecordBuilder record(out, Opcode::chunk_index);
    record.put(chunk.range.first).put(chunk.range.last).put(chunk.offset).put(chunk.length);
    record.put(static_cast<std::uint32_t>(chunk.indexes.size() * kEntry));
    for (const auto& [channel, offset] : chunk.indexes) record.put(channel).put(offset);
    record.put(chunk.index_length).put(kZstd).put(chunk.compressed).put(chunk.uncompressed);
  }
}

void McapWriter::append_metadata_indexes(std::string& out) const {
  for (const MetadataPlace& place : metadata_) {
    RecordBuilder(out, Opcode::metadata_index)
        .put(place.offset)
        .put(place.length)
        .put(std::string_view(place.name));
  }
}

void McapWriter::finish() {
  end_chunk();
  std::string end;
  RecordBuilder(end, Opcode::data_end).put(crc_);
  write(end);

  const std::uint64_t start = offset_;
  std::string summary;
  std::string offsets;
  const auto add_group = [&](Opcode opcode, const auto& append) {
    const std::size_t before = summary.size();
    append(summary);
    if (summary.size() == before) return;
    RecordBuilder(offsets, Opcode::summary_offset)
        .put(static_cast<std::uint8_t>(opcode))
        .put(start + before)
        .put(std::uint64_t{summary.size() - before});
  };
  add_group(Opcode::schema, [this](std::string& out) {
    out += schemas_;
  });
  add_group(Opcode::channel, [this](std::string& out) {
    out += channels_;
  });
  add_group(Opcode::statistics, [this](std::string& out) {
    append_statistics(out);
  });
  add_group(Opcode::metadata_index, [this](std::string& out) {
    append_metadata_indexes(out);
  });
  add_group(Opcode::chunk_index, [this](std::string& out) {
    append_chunk_indexes(out);
  });
  const std::uint64_t start_of_offsets = start + summary.size();
  summary += offsets;
  {
    RecordBuilder footer(summary, Opcode::footer);
    footer.put(start).put(start_of_offsets).put(std::uint32_t{0});
  }
  // Covers the summary and the footer up to this checksum.
  summary.resize(summary.size() - sizeof(std::uint32_t));
  const std::uint32_t crc = crc_of(summary);
  const void* const bytes = &crc;
  summary.append(static_cast<const char*>(bytes), sizeof(crc)).append(kMcapMagic);
  write(summary);
}

}  // namespace vdrive::recording
