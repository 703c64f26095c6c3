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

// The file format of a journal, described in docs/reference/journal.md: chunks, each with a check,
// which contain records.

/// A journal cannot be read. The message names the error and the byte offset.
class JournalError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Takes the bytes of a journal. @throws std::system_error when they cannot be written
using JournalSink = std::function<void(std::span<const std::byte> bytes)>;

/// A change to an axis between two ticks.
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
  ObjectAddress address{};  ///< write, stored
  std::int64_t value = 0;   ///< write, stored

  friend bool operator==(const JournalChange&, const JournalChange&) = default;
};

/// The author of the records that follow, up to the next record of this type. Before the first one,
/// and in journals of version 1, the author is unknown.
struct JournalAuthor {
  enum class Means : std::uint8_t {
    none = 0,     ///< the bench itself, for example while it shuts down
    request = 1,  ///< an acyclic request of a session
    frame = 2,    ///< a command frame of a session
  };

  Means means = Means::none;
  std::uint64_t session = 0;

  friend bool operator==(const JournalAuthor&, const JournalAuthor&) = default;
};

/// A refused write. It changed nothing, so a replay skips it.
struct JournalRefusal {
  std::uint16_t axis = 0;  ///< index on the bench, from 0
  ObjectAddress address{};
  std::int64_t value = 0;
  std::uint32_t reason = 0;  ///< REASON_... of the wire contract, or an SDO abort code

  friend bool operator==(const JournalRefusal&, const JournalRefusal&) = default;
};

/// A record between two ticks.
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

/// The complete state of the axes after a tick.
struct JournalSnapshot {
  enum class Cause : std::uint8_t { start = 1, restored = 2, resumed = 3 };

  Cause cause = Cause::start;
  std::uint64_t tick = 0;  ///< the last completed tick
  std::uint64_t lost = 0;  ///< resumed: the number of ticks missing before it
  std::vector<std::byte> state{};

  friend bool operator==(const JournalSnapshot&, const JournalSnapshot&) = default;
};

/// The end mark of a journal that was closed properly: its totals.
struct JournalEnd {
  std::uint64_t ticks = 0;
  std::uint64_t changes = 0;
  std::uint64_t lost = 0;

  friend bool operator==(const JournalEnd&, const JournalEnd&) = default;
};

using JournalRecord = std::variant<JournalChange, JournalRefusal, JournalAuthor, JournalTick,
                                   JournalSnapshot, JournalEnd>;

class JournalWriter {
 public:
  /// Writes the head. @throws what the sink throws, as all other members do
  JournalWriter(JournalSink sink, const JournalStart& start);

  void write(const JournalChange& change);
  void write(const JournalRefusal& refusal);
  void write(const JournalAuthor& author);
  void write(const JournalSnapshot& snapshot);
  /// Writes a tick, and a jump before it if `number` is not the next number.
  void write_tick(std::uint64_t number, const StatusDigest& digest,
                  std::span<const std::uint32_t> rows);
  /// Passes the buffered records to the sink.
  void flush();
  void end();

 private:
  void flush_if_large();

  JournalSink sink_;
  std::vector<std::byte> records_;  ///< of the chunk being filled
  std::vector<std::byte> chunk_;
  std::uint32_t sequence_ = 0;
  std::uint64_t last_tick_ = 0;
  std::optional<std::uint64_t> last_image_;  ///< nullopt: the next tick is written in full
  JournalEnd totals_;
};

/// Reads a journal from its first record to its last.
class JournalReader {
 public:
  /// Reads the head. @throws JournalError
  explicit JournalReader(std::istream& file);

  [[nodiscard]] const JournalStart& start() const noexcept { return start_; }

  /// @return whether it records authors and refusals: version 2 and later.
  [[nodiscard]] bool has_authors() const noexcept { return format_ >= 2; }

  /// @return the next record, or nullopt at the end of the file. An unfinished chunk at the end, as
  ///         a killed service leaves it, is skipped.
  /// @throws JournalError when something before the end is damaged or missing
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
  JournalTick tick_;  ///< the last tick
};

}  // namespace vdrive::service
