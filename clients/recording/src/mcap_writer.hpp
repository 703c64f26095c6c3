// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mcap_format.hpp"
#include "messages.hpp"
#include "output_file.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::recording {

/// Writes an MCAP file: CDR messages in zstd chunks, each with its indexes, and a summary. What has
/// been written is readable without the rest. Each call throws the exceptions of the output; the
/// writer must not be used after that.
class McapWriter {
 public:
  /// Writes the beginning of the file.
  /// @param library name of the writer, as information for readers
  McapWriter(std::unique_ptr<Output> output, std::string_view library);
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// @return its number.
  std::uint16_t add_schema(const bridge::MessageSchema& schema);

  /// @return its number.
  std::uint16_t add_channel(std::string_view topic, std::uint16_t schema, const TextMap& metadata);

  /// Written immediately, before the chunk being filled.
  void add_metadata(std::string_view name, const TextMap& metadata);

  /// @param time of the message [ns]
  /// @param bytes CDR with its encapsulation header
  void add_message(std::uint16_t channel, std::uint64_t time, std::string_view bytes);

  /// @return the bytes of the chunk being filled, before compression.
  [[nodiscard]] std::size_t pending() const noexcept { return chunk_.size(); }

  /// Compresses and writes the chunk being filled, if it has a message.
  void end_chunk();

  /// Writes the end of the file, with the summary.
  void finish();

 private:
  /// A message in the chunk being filled.
  struct Place {
    std::uint64_t time = 0;
    std::uint64_t offset = 0;
  };

  struct TimeRange {
    std::uint64_t first = 0;
    std::uint64_t last = 0;

    void add(std::uint64_t time, bool is_first) noexcept;
  };

  struct ChunkPlace {
    TimeRange range{};
    std::uint64_t offset = 0;
    std::uint64_t length = 0;
    std::map<std::uint16_t, std::uint64_t> indexes{};  ///< offset of the index, by channel
    std::uint64_t index_length = 0;
    std::uint64_t compressed = 0;
    std::uint64_t uncompressed = 0;
  };

  struct MetadataPlace {
    std::string name;
    std::uint64_t offset = 0;
    std::uint64_t length = 0;
  };

  struct Compressor;

  void write(std::string_view bytes);
  void write_chunk(ChunkPlace& place);
  void write_indexes(ChunkPlace& place);
  void append_statistics(std::string& out) const;
  void append_chunk_indexes(std::string& out) const;
  void append_metadata_indexes(std::string& out) const;

  std::unique_ptr<Output> output_;
  std::unique_ptr<Compressor> compressor_;
  std::uint64_t offset_ = 0;  ///< bytes written
  std::uint32_t crc_ = 0;     ///< of these bytes
  std::string schemas_;       ///< their records, repeated in the summary
  std::string channels_;
  std::uint16_t schema_count_ = 0;
  std::vector<std::uint32_t> sequences_;      ///< number of messages of each channel
  std::string chunk_;                         ///< being filled
  std::vector<std::vector<Place>> in_chunk_;  ///< by channel
  std::vector<std::uint16_t> used_in_chunk_;  ///< channels with messages in it
  TimeRange chunk_range_;
  TimeRange range_;
  std::uint64_t message_count_ = 0;
  std::vector<ChunkPlace> chunks_;
  std::vector<MetadataPlace> metadata_;
  std::string buffer_;
};

}  // namespace vdrive::recording
