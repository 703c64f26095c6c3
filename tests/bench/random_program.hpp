// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "journal/journal_file.hpp"
#include "vdrive/client.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::bench {

inline constexpr int kCommandsOfAProgram = 25;

/// What a program sees of its calls and of the axes; two programs are compared by it.
class ProgramLog {
 public:
  void note(const client::Outcome& outcome) {
    text_ << static_cast<int>(outcome.kind()) << ' ' << outcome.code() << ' ' << outcome.message()
          << '\n';
  }

  void note(const client::Observation& seen) {
    text_ << "tick " << seen.tick;
    for (const client::AxisSnapshot& axis : seen.axes) {
      text_ << (axis.owner_session == 0 ? " free" : " owned") << axis.owner_epoch << '/'
            << axis.last_sequence;
      for (const StatusMember& member : status_members()) {
        if (member.is_published) text_ << ' ' << member.value(axis.status);
      }
    }
    text_ << '\n';
  }

  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
};

/// A random program: the same for the same seed.
class RandomProgram {
 public:
  RandomProgram(client::Session& session, std::uint32_t seed) : session_(session), random_(seed) {
    for (client::Axis& axis : session_.axes(1).value()) {
      ids_.push_back(axis.id());
      axes_.push_back(axis);
    }
  }

  std::string run() {
    for (int count = 0; count < kCommandsOfAProgram; ++count) {
      command(axes_[below(axes_.size())]);
      const auto seen = session_.observe(ids_);
      log_.note(seen.outcome());
      if (seen) log_.note(*seen);
    }
    return log_.text();
  }

 private:
  std::uint32_t below(std::size_t count) { return static_cast<std::uint32_t>(random_() % count); }

  void command(client::Axis& axis) {
    const client::CallOptions at_once{.timeout = std::chrono::seconds(2),
                                      .until = client::Until::in_force};
    const auto target = static_cast<std::int32_t>(below(40'000)) - 20'000;
    switch (below(13)) {
      case 0:
      case 1:
        return log_.note(axis.enable(at_once));
      case 2:
      case 3:
        return log_.note(axis.move_to(
            target, {.velocity = 1'000 + below(50'000), .queue = below(2) == 0, .call = at_once}));
      case 4:
        return log_.note(axis.halt(at_once));
      case 5:
        return log_.note(axis.resume(at_once));
      case 6:
        return log_.note(axis.quick_stop(at_once));
      case 7:
        return log_.note(axis.reset_fault(at_once));
      case 8:
        return log_.note(axis.write({0x6081, 0}, below(200'000)).outcome());
      case 9:
        return log_.note(axis.disturb(client::Disturbance::load_torque, below(2'000)).outcome());
      case 10:
        return log_.note(axis.disable(at_once));
      case 11:
        return log_.note(axis.store());
      default:
        return log_.note(session_.step(1, 1 + below(400)).outcome());
    }
  }

  client::Session& session_;
  std::minstd_rand random_;
  std::vector<client::AxisId> ids_;
  std::vector<client::Axis> axes_;
  ProgramLog log_;
};

/// A journal without its head, which names the network.
inline std::vector<service::JournalRecord> records_of(const std::filesystem::path& file) {
  std::ifstream bytes(file, std::ios::binary);
  service::JournalReader reader(bytes);
  std::vector<service::JournalRecord> records;
  while (auto record = reader.next()) records.push_back(std::move(*record));
  return records;
}

}  // namespace vdrive::bench
