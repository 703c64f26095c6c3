// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "journal/journal_file.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/object_text.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <variant>

namespace vdrive::test {

/// The result of a comparison of two journals.
struct JournalComparison {
  std::string difference;  ///< the first, or why a journal is incomplete; empty = none
  std::uint64_t ticks = 0;
  std::uint64_t changes = 0;
  std::uint64_t snapshots = 0;
};

/// Describes a record in the report of a difference.
struct RecordText {
  std::string operator()(const service::JournalChange& change) const {
    return "change " + std::to_string(static_cast<int>(change.kind)) + " of the axis at " +
           std::to_string(change.axis) + ": " + object_text(change.address) + " = " +
           std::to_string(change.value);
  }

  std::string operator()(const service::JournalRefusal& refusal) const {
    return "refusal " + std::to_string(refusal.reason) + " to the axis at " +
           std::to_string(refusal.axis) + ": " + object_text(refusal.address) + " = " +
           std::to_string(refusal.value);
  }

  std::string operator()(const service::JournalAuthor& author) const {
    return "author " + std::to_string(author.session);
  }

  std::string operator()(const service::JournalTick& tick) const {
    return "tick " + std::to_string(tick.number);
  }

  std::string operator()(const service::JournalSnapshot& snapshot) const {
    return "snapshot " + std::to_string(static_cast<int>(snapshot.cause)) + " at tick " +
           std::to_string(snapshot.tick) + " of " + std::to_string(snapshot.state.size()) +
           " bytes, " + std::to_string(snapshot.lost) + " ticks lost before it";
  }

  std::string operator()(const service::JournalEnd& end) const {
    return "end after " + std::to_string(end.ticks) + " ticks and " + std::to_string(end.changes) +
           " changes, " + std::to_string(end.lost) + " ticks lost";
  }
};

/// @return a journal's configuration without its sections "wire" and "network".
inline std::string without_wire(const std::string& configuration) {
  std::istringstream lines(configuration);
  std::string kept;
  bool is_of_wire = false;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(' ')) is_of_wire = line == "wire:" || line == "network:";
    if (!is_of_wire) kept += line + '\n';
  }
  return kept;
}

/// Reads two journals side by side.
class JournalPair {
 public:
  JournalPair(const std::filesystem::path& one, const std::filesystem::path& other)
      : one_(one), other_(other) {}

  /// @return the first difference, or what is missing at the end.
  JournalComparison compare() {
    compare_heads();
    while (result_.difference.empty()) {
      const auto here = one_.next();
      const auto there = other_.next();
      if (!here && !there) {
        require_whole(one_);
        require_whole(other_);
        break;
      }
      compare(here, there);
    }
    return result_;
  }

 private:
  using Record = std::optional<service::JournalRecord>;

  struct File {
    explicit File(const std::filesystem::path& path)
        : name(path.filename()), bytes(path, std::ios::binary), reader(bytes) {}

    /// Skips the authors, because sessions have different numbers in each run.
    Record next() {
      Record record = reader.next();
      while (record && std::holds_alternative<service::JournalAuthor>(*record)) {
        record = reader.next();
      }
      return record;
    }

    std::string name;
    std::ifstream bytes;
    service::JournalReader reader;
    Record last{};
  };

  void compare_heads() {
    const service::JournalStart& here = one_.reader.start();
    const service::JournalStart& there = other_.reader.start();
    const bool is_same = here.layout == there.layout && here.rows == there.rows &&
                         here.axes_per_row == there.axes_per_row && here.version == there.version;
    if (!is_same) result_.difference = "the heads differ";
    const std::string configured = without_wire(here.configuration);
    const std::string other = without_wire(there.configuration);
    if (configured != other) {
      result_.difference = "the configurations differ:\n" + configured + "and\n" + other;
    }
  }

  void compare(const Record& here, const Record& there) {
    if (here == there) {
      count(*here);
    } else {
      result_.difference = "record " + std::to_string(records_) + ", after tick " +
                           std::to_string(tick_) + ": " + text_of(here) + " in " + one_.name +
                           ", " + text_of(there) + " in " + other_.name +
                           part_of_tick(here, there) + part_of_snapshot(here, there);
    }
    one_.last = here;
    other_.last = there;
    ++records_;
  }

  void count(const service::JournalRecord& record) {
    if (const auto* const tick = std::get_if<service::JournalTick>(&record)) {
      ++result_.ticks;
      tick_ = tick->number;
    } else if (const auto* const snapshot = std::get_if<service::JournalSnapshot>(&record)) {
      ++result_.snapshots;
      tick_ = snapshot->tick;
    } else if (std::holds_alternative<service::JournalChange>(record)) {
      ++result_.changes;
    }
  }

  /// The journal of a killed service has no end; that of a service with a slow disk has gaps.
  void require_whole(const File& file) {
    const auto* const end = file.last ? std::get_if<service::JournalEnd>(&*file.last) : nullptr;
    const bool is_whole = end != nullptr && file.reader.torn_bytes() == 0 && end->lost == 0 &&
                          end->ticks == result_.ticks && end->changes == result_.changes;
    if (is_whole || !result_.difference.empty()) return;
    result_.difference = file.name + " is not whole: its last record is " + text_of(file.last) +
                         ", behind " + std::to_string(result_.ticks) + " ticks and " +
                         std::to_string(result_.changes) + " changes; " +
                         std::to_string(file.reader.torn_bytes()) + " torn bytes follow";
  }

  static std::string text_of(const Record& record) {
    return record ? std::visit(RecordText(), *record) : "no record";
  }

  /// @return the status members that differ, and the rows of axes in which they do.
  static std::string part_of_tick(const Record& one, const Record& other) {
    const auto* const here = one ? std::get_if<service::JournalTick>(&*one) : nullptr;
    const auto* const there = other ? std::get_if<service::JournalTick>(&*other) : nullptr;
    if (here == nullptr || there == nullptr || here->number != there->number) return "";
    std::string text = ": different are";
    for (std::size_t i = 0; i < kStatusMembers; ++i) {
      if (here->digest.members[i] == there->digest.members[i]) continue;
      text += ' ' + std::string(status_members()[i].name);
    }
    for (std::size_t i = 0; i < here->rows.size() && i < there->rows.size(); ++i) {
      if (here->rows[i] != there->rows[i]) text += ", row " + std::to_string(i);
    }
    return text;
  }

  /// @return the place where the states begin to differ.
  static std::string part_of_snapshot(const Record& one, const Record& other) {
    const auto* const here = one ? std::get_if<service::JournalSnapshot>(&*one) : nullptr;
    const auto* const there = other ? std::get_if<service::JournalSnapshot>(&*other) : nullptr;
    if (here == nullptr || there == nullptr || here->state == there->state) return "";
    const auto place = std::ranges::mismatch(here->state, there->state).in1;
    return ": different from byte " + std::to_string(place - here->state.begin()) + " on";
  }

  File one_;
  File other_;
  std::uint64_t records_ = 0;
  std::uint64_t tick_ = 0;  ///< the last tick that both have
  JournalComparison result_;
};

/// Compares two journals record by record, ignoring the configuration of wire and network and the
/// authors of writes. Both must be complete: ended properly, with every tick.
inline JournalComparison compare_journals(const std::filesystem::path& one,
                                          const std::filesystem::path& other) {
  return JournalPair(one, other).compare();
}

}  // namespace vdrive::test
