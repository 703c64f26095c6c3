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

/// One record of a file; those of a chunk stand in the place of the chunk.
struct McapRecord {
  Opcode opcode = Opcode::header;
  std::string_view body{};   ///< valid up to the next record
  std::uint64_t offset = 0;  ///< in the file; of a record of a chunk that of the chunk
  bool is_in_chunk = false;
};

/// @return such as "the channel record at byte 120".
[[nodiscard]] std::string where(const McapRecord& record);

/// Reads a file of MCAP from its beginning to where it ends, by any writer: without its summary,
/// so that a file that was cut off is readable up to there. Chunks may be uncompressed or of zstd.
/// Checks the checksums of chunks, of the data and of the summary where the file has them.
class McapReader {
 public:
  /// @param file from its beginning
  /// @throws RecordingError when it does not begin as MCAP does
  explicit McapReader(std::istream& file);
  ~McapReader();
  McapReader(const McapReader&) = delete;
  McapReader& operator=(const McapReader&) = delete;

  /// @return the next record; nothing at the end.
  /// @throws RecordingError with the place in the file when a record is damaged, or compressed in
  ///         another way
  std::optional<McapRecord> next();

  /// Once next() has returned nothing.
  /// @return where and in what the file ends before its end; empty for a whole file.
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
  std::uint32_t crc_ = 0;     ///< of them, from the summary on of those of the summary
  bool has_ended_ = false;
  std::string cut_;
  std::string body_;
  std::string chunk_;      ///< uncompressed
  std::string_view left_;  ///< of it, not read yet
  std::uint64_t chunk_offset_ = 0;
};

}  // namespace vdrive::recording
