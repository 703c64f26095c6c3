// SPDX-License-Identifier: Apache-2.0
#include "mcap_reader.hpp"

#include "recording.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <zstd.h>

#include <algorithm>
#include <array>

namespace vdrive::recording {
namespace {

// The largest chunk that is read. Limited, because a file of a few kB may claim any size; writers
// make chunks of 1 to 4 MiB. Reading a chunk takes up to twice its size in memory.
constexpr int kLargestWindow = 26;                                           // power of two [bytes]
constexpr std::uint64_t kLargestChunk = std::uint64_t{1} << kLargestWindow;  // [bytes]
constexpr std::size_t kStep = std::size_t{1} << 20U;                         // [bytes]

constexpr std::array<std::string_view, 16> kNames{
    "",         "header",         "footer",         "schema",     "channel",          "message",
    "chunk",    "message index",  "chunk index",    "attachment", "attachment index", "statistics",
    "metadata", "metadata index", "summary offset", "data end"};

std::string name_of(Opcode opcode) {
  const auto number = static_cast<std::size_t>(opcode);
  if (number != 0 && number < kNames.size()) return std::string(kNames.at(number)) + " record";
  return "record of the kind " + hex(number, 2);
}

std::string at(std::uint64_t offset) {
  return " at byte " + std::to_string(offset);
}

}  // namespace

std::string where(const McapRecord& record) {
  return "the " + name_of(record.opcode) + (record.is_in_chunk ? " in the chunk" : "") +
         at(record.offset);
}

/// Allocates memory as the decompression proceeds, not for the size claimed by the file.
struct McapReader::Decompressor {
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context{ZSTD_createDCtx(), &ZSTD_freeDCtx};

  /// @return an error's name, or nothing.
  [[nodiscard]] std::string run(std::string_view bytes, std::uint64_t size,
                                std::string& out) const {
    ZSTD_DCtx_reset(context.get(), ZSTD_reset_session_only);
    ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kLargestWindow);
    ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
    out.clear();
    out.reserve(size);  // memory is only used once it is written to
    std::size_t filled = 0;
    while (filled < size) {
      out.resize(std::min<std::uint64_t>(size, filled + kStep));
      ZSTD_outBuffer space{out.data(), out.size(), filled};
      const std::size_t before = in.pos;
      const std::size_t left = ZSTD_decompressStream(context.get(), &space, &in);
      if (ZSTD_isError(left) != 0U) return ZSTD_getErrorName(left);
      if (space.pos == filled && in.pos == before) break;
      filled = space.pos;
    }
    out.resize(filled);
    if (filled != size) return "it has " + std::to_string(filled) + " bytes";
    return {};
  }
};

McapReader::McapReader(std::istream& file)
    : file_(file), decompressor_(std::make_unique<Decompressor>()) {
  file_.seekg(0, std::ios::end);
  size_ = static_cast<std::uint64_t>(std::max<std::streamoff>(file_.tellg(), 0));
  file_.clear();
  file_.seekg(0);
  std::string magic;
  if (!read(magic, std::min<std::uint64_t>(kMcapMagic.size(), size_)) ||
      !kMcapMagic.starts_with(magic) || magic.empty()) {
    throw RecordingError("it is not an MCAP file: wrong magic bytes");
  }
}

McapReader::~McapReader() = default;

bool McapReader::read(std::string& bytes, std::uint64_t size) {
  if (size > size_ - offset_) return false;
  bytes.resize(size);
  file_.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!file_) throw RecordingError("it cannot be read" + at(offset_));
  offset_ += size;
  return true;
}

std::optional<McapRecord> McapReader::next() {
  while (!has_ended_) {
    if (!left_.empty()) return next_of_chunk();
    const auto record = next_of_file();
    if (!record || record->opcode != Opcode::chunk) return record;
    open_chunk(*record);
  }
  return std::nullopt;
}

std::optional<McapRecord> McapReader::next_of_file() {
  const std::uint64_t offset = offset_;
  std::string head;
  if (!read(head, kMcapHead)) {
    has_ended_ = true;
    cut_ = "it ends" + at(size_) + ", without an end record";
    return std::nullopt;
  }
  BodyReader reader(head, "the record" + at(offset));
  McapRecord record{.opcode = static_cast<Opcode>(reader.get<std::uint8_t>()), .offset = offset};
  const auto length = reader.get<std::uint64_t>();
  if (record.opcode == Opcode{0}) {
    throw RecordingError("the record" + at(offset) + " has the kind 0, which does not exist");
  }
  if (!read(body_, length)) {
    has_ended_ = true;
    cut_ = "it ends" + at(size_) + ", within " + where(record);
    return std::nullopt;
  }
  record.body = body_;
  check_sums(record, head);
  if (record.opcode == Opcode::footer) check_end(record);
  return record;
}

/// The checksum of the data is in the record after the data, that of the summary in the last record
/// of the summary.
void McapReader::check_sums(const McapRecord& record, std::string_view head) {
  if (record.offset == kMcapMagic.size()) crc_ = crc_of(kMcapMagic);
  if (record.opcode == Opcode::data_end) {
    const auto expected = BodyReader(record.body, where(record)).get<std::uint32_t>();
    if (expected != 0 && expected != crc_) {
      throw RecordingError("the data before " + where(record) + " has a wrong checksum");
    }
    crc_ = 0;
    return;
  }
  if (record.opcode == Opcode::footer) {
    constexpr std::size_t kSummed = 16;
    BodyReader body(record.body, where(record));
    const std::string_view summed = body.take(kSummed);
    const auto expected = body.get<std::uint32_t>();
    if (expected != 0 && expected != crc_of(summed, crc_of(head, crc_))) {
      throw RecordingError("the summary before " + where(record) + " has a wrong checksum");
    }
  }
  crc_ = crc_of(record.body, crc_of(head, crc_));
}

void McapReader::check_end(const McapRecord& record) {
  has_ended_ = true;
  std::string magic;
  if (!read(magic, std::min<std::uint64_t>(kMcapMagic.size(), size_ - offset_)) ||
      magic != kMcapMagic) {
    cut_ = "it ends" + at(size_) + ", after " + where(record);
  }
}

void McapReader::open_chunk(const McapRecord& record) {
  BodyReader body(record.body, where(record));
  (void)body.take(2 * sizeof(std::uint64_t));  // times
  const auto size = body.get<std::uint64_t>();
  const auto crc = body.get<std::uint32_t>();
  const std::string_view compression = body.get_text();
  const std::string_view bytes = body.take(body.get<std::uint64_t>());
  if (size > kLargestChunk) {
    throw RecordingError(where(record) + " claims " + std::to_string(size) + " bytes; at most " +
                         std::to_string(kLargestChunk) + " are read");
  }
  if (compression == "zstd") {
    const std::string error = decompressor_->run(bytes, size, chunk_);
    if (!error.empty()) {
      throw RecordingError(where(record) + " cannot be decompressed to " + std::to_string(size) +
                           " bytes: " + error);
    }
  } else if (compression.empty()) {
    chunk_ = bytes;
  } else {
    throw RecordingError(where(record) + " is compressed with " + in_quotes(compression) +
                         "; only zstd or no compression is supported");
  }
  if (crc != 0 && crc != crc_of(chunk_)) {
    throw RecordingError(where(record) + " has a wrong checksum");
  }
  left_ = chunk_;
  chunk_offset_ = record.offset;
}

std::optional<McapRecord> McapReader::next_of_chunk() {
  McapRecord record{.opcode = Opcode::chunk, .offset = chunk_offset_};
  BodyReader reader(left_, where(record));
  const auto opcode = static_cast<Opcode>(reader.get<std::uint8_t>());
  if (opcode == Opcode::chunk || opcode == Opcode::footer) {
    throw RecordingError(where(record) + " contains a " + name_of(opcode) +
                         ", which is not allowed there");
  }
  record.body = reader.take(reader.get<std::uint64_t>());
  record.opcode = opcode;
  record.is_in_chunk = true;
  left_ = reader.rest();
  return record;
}

}  // namespace vdrive::recording
