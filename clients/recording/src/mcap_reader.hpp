// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mcap_format.hpp"

#include <cstdint>
#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::recording {

/// One record of a file; the records in a chunk replace the chunk.
struct McapRecord {
  Opcode opcode = Opcode::header;
  std::string_view body{};   ///< valid until the next record
  std::uint64_t offset = 0;  ///< in the file; for a record in a chunk, the offset of the chunk
  bool is_in_chunk = false;
};

/// @return such as "the channel record at byte 120".
[[nodiscard]] std::string where(const McapRecord& record);

/// Reads an MCAP file of any writer from beginning to end. Does not use the summary, so that a
/// truncated file can be read as far as it goes. Chunks may be uncompressed or compressed with
/// zstd. Verifies the checksums of chunks, data and summary if the file has them.
class McapReader {
 public:
  /// @param file positioned at its beginning
  /// @throws RecordingError if it does not begin like an MCAP file
  explicit McapReader(std::istream& file);
  ~McapReader();
  McapReader(const McapReader&) = delete;
  McapReader& operator=(const McapReader&) = delete;

  /// @return the next record; nothing at the end.
  /// @throws RecordingError with the place in the file if a record is damaged or uses another
  ///         compression
  std::optional<McapRecord> next();

  /// Valid once next() has returned nothing.
  /// @return where, and in which record, the file is truncated; empty for a complete file.
  [[nodiscard]] const std::string& cut() const noexcept { return cut_; }

 private:
  struct Decompressor;

  std::optional<McapRecord> next_of_file();
  std::optional<McapRecord> next_of_chunk();
  bool read(std::string& bytes, std::uint64_t size);
  void open_chunk(const McapRecord& record);
  void check_end(const McapRecord& record);
  void check_sums(const McapRecord& record, std::string_view head);

  std::istream& file_;
  std::unique_ptr<Decompressor> decompressor_;
  std::uint64_t size_ = 0;    ///< of the file
  std::uint64_t offset_ = 0;  ///< bytes read
  std::uint32_t crc_ = 0;     ///< of these bytes; from the summary on, of the summary only
  bool has_ended_ = false;
  std::string cut_;
  std::string body_;
  std::string chunk_;      ///< uncompressed
  std::string_view left_;  ///< the unread part of it
  std::uint64_t chunk_offset_ = 0;
};

}  // namespace vdrive::recording
