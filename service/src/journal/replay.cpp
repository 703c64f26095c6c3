// SPDX-License-Identifier: Apache-2.0
#include "journal/replay.hpp"

#include "base/step_pool.hpp"
#include "configuration/configuration_file.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/status_digest.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <variant>
#include <vector>

namespace vdrive::service {
namespace {

constexpr std::size_t kLongestNumber = 32;

std::string speed_text(double number) {
  std::array<char, kLongestNumber> text{};
  std::snprintf(text.data(), text.size(), number < 10.0 ? "%.1f" : "%.0f",
                number);  // NOLINT(*-vararg)
  return text.data();
}

/// Older journals of benches without security have an empty `security` directory in their
/// configuration, which is an error now.
std::string without_empty_security(std::string configuration) {
  constexpr std::string_view kEmpty = "\n  security: \"\"";
  if (const std::size_t place = configuration.find(kEmpty); place != std::string::npos) {
    configuration.erase(place, kEmpty.size());
  }
  return configuration;
}

Configuration configuration_of(const JournalStart& start) {
  if (start.layout != AxisBank::snapshot_layout()) {
    throw JournalError("it was written by vdrived " + escaped(start.version) +
                       ", whose state has a different layout; replay it with that version");
  }
  try {
    return parse_configuration(without_empty_security(start.configuration), "its configuration");
  } catch (const std::exception& error) {
    throw JournalError(error.what());
  }
}

/// A journal being replayed. The overloads of apply() return whether the replay still agrees with
/// it.
class Replay {
 public:
  Replay(JournalReader& reader, const ReplayOptions& options)
      : reader_(reader),
        options_(options),
        configuration_(configuration_of(reader.start())),
        bank_(bank_axes(configuration_), configuration_.period),
        pool_(bank_, options.threads.value_or(configuration_.threads)),
        rows_(reader.start().rows) {
    const std::size_t per_row = reader.start().axes_per_row;
    if (rows_.size() != (bank_.size() + per_row - 1) / per_row) {
      throw JournalError("its header has " + std::to_string(rows_.size()) + " rows of up to " +
                         std::to_string(per_row) + " axes, but its configuration has " +
                         std::to_string(bank_.size()) + " axes");
    }
  }

  ReplayResult run() {
    const auto begin = std::chrono::steady_clock::now();
    bool agrees = true;
    if (options_.observer != nullptr) {
      options_.observer->begins(configuration_, reader_.has_authors());
    }
    while (agrees) {
      const auto record = reader_.next();
      if (!record) break;
      if (ended_)
        throw JournalError("it has data after its end mark: it was modified, or files were joined");
      agrees = std::visit(
          [this](const auto& content) {
            return apply(content);
          },
          *record);
    }
    if (ended_ && reader_.torn_bytes() > 0)
      throw JournalError("it has data after its end mark: it was modified, or files were joined");
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    result_.agrees = agrees;
    result_.is_complete = lost_ == 0 && ended_;
    if (agrees) result_.text = summary(wall.count());
    return result_;
  }

 private:
  bool apply(const JournalChange& change) {
    require_start();
    require_axis(change.axis);
    ++result_.changes;
    AbortCode code = AbortCode::none;
    switch (change.kind) {
      case JournalChange::Kind::write:
        code = bank_.write(change.axis, change.address, change.value);
        break;
      case JournalChange::Kind::power_cycle:
        bank_.power_cycle(change.axis);
        break;
      case JournalChange::Kind::connection_loss:
        bank_.report_connection_loss(change.axis);
        break;
      case JournalChange::Kind::stored:
        code = bank_.set_stored(change.axis, change.address, change.value);
        break;
      case JournalChange::Kind::forgot:
        bank_.forget_stored(change.axis);
        break;
    }
    if (code == AbortCode::none) {
      tell(change);
    } else {
      result_.text = "tick " + std::to_string(tick_ + 1) + ": " + name_of(change.axis) +
                     ": the write of " + std::to_string(change.value) + " to " +
                     object_text(change.address) +
                     " was accepted when it was recorded and is refused now";
    }
    return code == AbortCode::none;
  }

  bool apply(const JournalRefusal& refusal) {
    require_axis(refusal.axis);
    tell(refusal);
    return true;
  }

  bool apply(const JournalAuthor& author) {
    tell(author);
    return true;
  }

  bool apply(const JournalTick& tick) {
    require_start();
    pool_.step();
    tick_ = tick.number;
    ++result_.ticks;
    if (options_.observer != nullptr) options_.observer->stepped(tick_, bank_);
    if (result_.ticks % options_.check_interval != 0) return true;
    const StatusDigest digest = digest_of(bank_.statuses(), reader_.start().axes_per_row, rows_);
    if (digest.image == tick.digest.image) return true;
    result_.text = "tick " + std::to_string(tick.number) + ": " + place_of(digest, tick);
    return false;
  }

  bool apply(const JournalSnapshot& snapshot) {
    started_ = true;
    try {
      const bool was_restored = snapshot.cause == JournalSnapshot::Cause::restored;
      bank_.restore(bank_.snapshot_from(snapshot.state),
                    was_restored ? AxisBank::Memory::kept : AxisBank::Memory::of_snapshot);
    } catch (const std::invalid_argument& error) {
      throw JournalError(error.what());
    }
    if (snapshot.lost > 0) {
      lost_ += snapshot.lost;
      gaps_ += (gaps_.empty() ? "" : ", ") + std::to_string(tick_ + 1) + " to " +
               std::to_string(snapshot.tick);
    }
    tick_ = snapshot.tick;
    if (options_.observer != nullptr) options_.observer->restored(snapshot, bank_);
    return true;
  }

  bool apply(const JournalEnd& end) {
    if (end.ticks != result_.ticks || end.changes != result_.changes || end.lost != lost_) {
      throw JournalError("its end mark states " + std::to_string(end.ticks) + " ticks and " +
                         std::to_string(end.changes) + " changes, but it contains " +
                         std::to_string(result_.ticks) + " and " + std::to_string(result_.changes));
    }
    ended_ = true;
    return true;
  }

  template <typename Entry>
  void tell(const Entry& entry) {
    if (options_.observer != nullptr) options_.observer->entered(entry, bank_);
  }

  void require_axis(std::size_t axis) const {
    if (axis < bank_.size()) return;
    throw JournalError("tick " + std::to_string(tick_ + 1) + ": there is no axis with index " +
                       std::to_string(axis));
  }

  void require_start() const {
    if (!started_) throw JournalError("its first record is not a snapshot");
  }

  [[nodiscard]] std::string name_of(std::size_t axis) const {
    const NamedAxis& named = configuration_.axes[axis];
    return "axis " + std::to_string(named.number) + " (" + named.name + ")";
  }

  /// @return a text that names the first axis (or row of axes) and the first member that differ, or
  ///         says that the recorded checks do not show which they are.
  [[nodiscard]] std::string place_of(const StatusDigest& digest, const JournalTick& tick) const {
    const auto row =
        static_cast<std::size_t>(std::ranges::mismatch(rows_, tick.rows).in1 - rows_.begin());
    const auto column = static_cast<std::size_t>(
        std::ranges::mismatch(digest.members, tick.digest.members).in1 - digest.members.begin());
    if (row == rows_.size() || column == kStatusMembers) {
      return "the status differs from the recorded one; the recorded checks do not show in which "
             "axis or member";
    }
    const StatusMember& member = status_members()[column];
    const std::size_t per_row = reader_.start().axes_per_row;
    const std::size_t first = row * per_row;
    const std::size_t last = std::min(first + per_row, bank_.size()) - 1;
    std::string text =
        first == last ? name_of(first) : "one of " + name_of(first) + " to " + name_of(last);
    text += ", member " + std::string(member.name);
    text += member.address.index == 0 ? "" : " (" + index_text(member.address.index) + ")";
    if (first == last) {
      text += ": replayed " + std::to_string(member.value(bank_.status(first))) +
              ", recorded another value";
    }
    return text + "; the replay stops at the first difference";
  }

  [[nodiscard]] std::string summary(double wall) const {
    const double drive =
        std::chrono::duration<double>(bank_.period()).count() * static_cast<double>(result_.ticks);
    std::string text = std::to_string(result_.ticks) + " ticks of " + std::to_string(bank_.size()) +
                       " axes, " + std::to_string(result_.changes) +
                       " changes: all checks agree, " +
                       speed_text(wall > 0.0 ? drive / wall : 0.0) + " x real time";
    if (!ended_) {
      text += "; the journal ends early, without an end mark: " + std::to_string(result_.ticks) +
              " of at least " + std::to_string(result_.ticks + reader_.torn_ticks()) +
              " ticks were replayed, up to tick " + std::to_string(tick_);
    }
    if (reader_.torn_bytes() > 0) {
      text +=
          "; it ends in " + std::to_string(reader_.torn_bytes()) + " bytes of an unfinished chunk";
    }
    if (lost_ > 0) text += "; " + std::to_string(lost_) + " ticks are missing: " + gaps_;
    return text;
  }

  JournalReader& reader_;
  const ReplayOptions& options_;
  Configuration configuration_;
  AxisBank bank_;
  StepPool pool_;
  std::vector<std::uint32_t> rows_;
  ReplayResult result_;
  std::uint64_t tick_ = 0;
  std::uint64_t lost_ = 0;
  std::string gaps_;
  bool started_ = false;
  bool ended_ = false;
};

}  // namespace

ReplayResult replay(std::istream& journal, const ReplayOptions& options) {
  JournalReader reader(journal);
  return Replay(reader, options).run();
}

ReplayResult replay(const std::filesystem::path& file, const ReplayOptions& options) {
  std::ifstream stream(file, std::ios::binary);
  if (std::filesystem::is_directory(file) || !stream) {
    throw JournalError(escaped(file.string(), kShownOfMessage) + ": cannot be read");
  }
  try {
    ReplayResult result = replay(stream, options);
    result.text = escaped(file.string(), kShownOfMessage) + ": " + result.text;
    return result;
  } catch (const JournalError& error) {
    throw JournalError(escaped(file.string(), kShownOfMessage) + ": " + error.what());
  }
}

}  // namespace vdrive::service
