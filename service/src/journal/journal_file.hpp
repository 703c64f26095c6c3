// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"
#include "vdrive/status_digest.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace vdrive::service {

/// The file of a journal, as docs/reference/journal.md describes it: chunks with a check each,
/// records in them.

/// A journal cannot be read. The message names the error and its byte.
class JournalError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Takes the bytes of a journal. @throws std::system_error when they cannot be kept
using JournalSink = std::function<void(std::span<const std::byte> bytes)>;

/// Something that was done to an axis between two ticks.
struct JournalChange {
  enum class Kind : std::uint8_t {
    write = 1,
    power_cycle = 2,
    connection_loss = 3,
    // 4 to 6 are ticks
    stored = 7,  ///< AxisBank::set_stored
    forgot = 8,  ///< AxisBank::forget_stored
  };

  Kind kind = Kind::write;
  std::uint16_t axis = 0;   ///< index on the bench, from 0
  ObjectAddress address{};  ///< written, stored
  std::int64_t value = 0;   ///< written, stored

  friend bool operator==(const JournalChange&, const JournalChange&) = default;
};

/// Who does what the records after this one say, until the next of these. Before the first one in a
/// journal, and in those of version 1, it is not known.
struct JournalAuthor {
  enum class Means : std::uint8_t {
    none = 0,     ///< the bench itself, such as one that shuts down
    request = 1,  ///< of a session, acyclic
    frame = 2,    ///< of a session, with set-points
  };

  Means means = Means::none;
  std::uint64_t session = 0;

  friend bool operator==(const JournalAuthor&, const JournalAuthor&) = default;
};

/// A write that was refused: it has changed nothing, and a replay leaves it out.
struct JournalRefusal {
  std::uint16_t axis = 0;  ///< index on the bench, from 0
  ObjectAddress address{};
  std::int64_t value = 0;
  std::uint32_t reason = 0;  ///< number of the wire contract, or abort code

  friend bool operator==(const JournalRefusal&, const JournalRefusal&) = default;
};

/// What happens between two ticks.
using JournalEntry = std::variant<JournalChange, JournalRefusal, JournalAuthor>;

/// The head of a journal.
struct JournalStart {
  std::uint64_t layout = 0;        ///< AxisBank::snapshot_layout
  std::uint32_t axes_per_row = 1;  ///< see StatusDigest
  std::uint32_t rows = 0;
  std::string version;        ///< of the program
  std::string configuration;  ///< YAML
};

/// One tick: its number and the check of its status images.
struct JournalTick {
  std::uint64_t number = 0;
  StatusDigest digest{};
  std::vector<std::uint32_t> rows{};

  friend bool operator==(const JournalTick&, const JournalTick&) = default;
};

/// The whole state of the axes after a tick.
struct JournalSnapshot {
  enum class Cause : std::uint8_t { start = 1, restored = 2, resumed = 3 };

  Cause cause = Cause::start;
  std::uint64_t tick = 0;  ///< the last completed one
  std::uint64_t lost = 0;  ///< resumed: how many ticks are missing before it
  std::vector<std::byte> state{};

  friend bool operator==(const JournalSnapshot&, const JournalSnapshot&) = default;
};

/// What a journal that was ended properly holds.
struct JournalEnd {
  std::uint64_t ticks = 0;
  std::uint64_t changes = 0;
  std::uint64_t lost = 0;

  friend bool operator==(const JournalEnd&, const JournalEnd&) = default;
};

using JournalRecord = std::variant<JournalChange, JournalRefusal, JournalAuthor, JournalTick,
                                   JournalSnapshot, JournalEnd>;

/// Writes a journal.
class JournalWriter {
 public:
  /// Writes the head. All members @throws what the sink throws.
  JournalWriter(JournalSink sink, const JournalStart& start);

  void write(const JournalChange& change);
  void write(const JournalRefusal& refusal);
  void write(const JournalAuthor& author);
  void write(const JournalSnapshot& snapshot);
  /// A tick whose number is not the next one jumped.
  void write_tick(std::uint64_t number, const StatusDigest& digest,
                  std::span<const std::uint32_t> rows);
  /// Hands what waits to the sink.
  void flush();
  /// The last record.
  void end();

 private:
  void flush_if_large();

  JournalSink sink_;
  std::vector<std::byte> records_;  ///< of the chunk that is being filled
  std::vector<std::byte> chunk_;
  std::uint32_t sequence_ = 0;
  std::uint64_t last_tick_ = 0;
  std::optional<std::uint64_t> last_image_;  ///< nothing: the next tick is written in full
  JournalEnd totals_;
};

/// Reads a journal from its first record to its last.
class JournalReader {
 public:
  /// Reads the head. @throws JournalError
  explicit JournalReader(std::istream& file);

  [[nodiscard]] const JournalStart& start() const noexcept { return start_; }

  /// @return whether it has authors and refusals: version 2 and later.
  [[nodiscard]] bool has_authors() const noexcept { return format_ >= 2; }

  /// @return the next record, or nothing at the end of the file.
  /// @throws JournalError when something in the middle is damaged or missing. An unfinished chunk
  /// at the end of the file is left out: a service that was killed leaves such a chunk.
  [[nodiscard]] std::optional<JournalRecord> next();

  /// @return the number of bytes of the unfinished chunk at the end of the file.
  [[nodiscard]] std::uint64_t torn_bytes() const noexcept { return torn_bytes_; }

  /// @return the number of ticks found in the unfinished chunk at the end of the file.
  [[nodiscard]] std::uint64_t torn_ticks() const noexcept { return torn_ticks_; }

 private:
  [[nodiscard]] bool read_chunk();
  [[nodiscard]] bool read_bytes(std::size_t length);
  void require_length(std::uint32_t kind, std::uint32_t length) const;
  void count_torn_ticks();
  [[nodiscard]] JournalRecord read_record();
  [[nodiscard]] JournalRecord read_change(JournalChange::Kind kind);
  [[nodiscard]] JournalRecord read_snapshot();
  void read_start();
  template <typename Number>
  [[nodiscard]] Number take();
  [[nodiscard]] ObjectAddress take_address();
  [[nodiscard]] std::string take_text();
  [[noreturn]] void fail(const std::string& what) const;

  std::istream& file_;
  JournalStart start_;
  std::uint32_t format_ = 0;
  std::uint32_t kind_ = 0;
  std::vector<std::byte> chunk_;
  std::size_t position_ = 0;
  std::uint64_t chunk_offset_ = 0;  ///< of the present chunk in the file
  std::uint64_t next_offset_ = 0;
  std::uint64_t torn_bytes_ = 0;
  std::uint64_t torn_ticks_ = 0;
  std::uint32_t sequence_ = 0;
  JournalTick tick_;  ///< the last one
};

}  // namespace vdrive::service
