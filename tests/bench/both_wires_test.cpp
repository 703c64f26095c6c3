// SPDX-License-Identifier: Apache-2.0
// The same program over the local bus and over DDS: the same answers, the same axes in every tick
// that is seen, and the same journal, which has every tick.
//
//   VDRIVE_SEQUENCES=1000 both_wires_test     as many random sequences of commands; 60 by default
#include "client/session_options.hpp"
#include "journal/journal_file.hpp"
#include "support/temporary_directory.hpp"
#include "tool/process.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/client.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::bench {
namespace {

using client::Axis;
using client::AxisId;
using client::Outcome;
using client::Session;
using client::Until;

constexpr int kAxes = 3;
constexpr int kCommands = 25;
constexpr const char* kConfiguration = VDRIVE_SOURCE_DIR "/tests/data/patient.yaml";

std::size_t number_of_sequences() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): before the first thread
  const char* const chosen = std::getenv("VDRIVE_SEQUENCES");
  return chosen == nullptr ? 60 : std::stoul(chosen);
}

/// What a program sees of its calls and of the axes; two programs are compared by it.
class Log {
 public:
  void note(const Outcome& outcome) {
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
class Program {
 public:
  Program(Session& session, std::uint32_t seed) : session_(session), random_(seed) {
    for (Axis& axis : session_.axes(1).value()) {
      ids_.push_back(axis.id());
      axes_.push_back(axis);
    }
  }

  std::string run() {
    for (int count = 0; count < kCommands; ++count) {
      command(axes_[below(axes_.size())]);
      const auto seen = session_.observe(ids_);
      log_.note(seen.outcome());
      if (seen) log_.note(*seen);
    }
    return log_.text();
  }

 private:
  std::uint32_t below(std::size_t count) { return static_cast<std::uint32_t>(random_() % count); }

  void command(Axis& axis) {
    const client::CallOptions at_once{.timeout = std::chrono::seconds(2), .until = Until::in_force};
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

  Session& session_;
  std::minstd_rand random_;
  std::vector<AxisId> ids_;
  std::vector<Axis> axes_;
  Log log_;
};

/// A journal without its head, which names the network.
std::vector<service::JournalRecord> records_of(const std::filesystem::path& file) {
  std::ifstream bytes(file, std::ios::binary);
  service::JournalReader reader(bytes);
  std::vector<service::JournalRecord> records;
  while (auto record = reader.next()) records.push_back(std::move(*record));
  return records;
}

/// The same bench over both wires, each with a journal.
class BothWires : public testing::Test {
 protected:
  void run_sequences(Session& local, Session& over_dds) {
    const std::array sessions{&local, &over_dds};
    std::array<std::uint64_t, 2> begins{};
    for (std::size_t wire = 0; wire < sessions.size(); ++wire) {
      begins[wire] = sessions[wire]->take_snapshot(1).value();
    }
    const std::size_t sequences = number_of_sequences();
    for (std::uint32_t seed = 1; seed <= sequences; ++seed) {
      std::array<std::string, 2> logs;
      for (std::size_t wire = 0; wire < sessions.size(); ++wire) {
        ASSERT_TRUE(sessions[wire]->release(1));
        ASSERT_TRUE(sessions[wire]->restore_snapshot(1, begins[wire]));
        logs[wire] = Program(*sessions[wire], seed).run();
      }
      ASSERT_EQ(logs[0], logs[1]) << "seed " << seed;
    }
  }

  [[nodiscard]] std::filesystem::path path(const char* name) const {
    return directory_.path() / name;
  }

 private:
  const test::TemporaryDirectory directory_;
};

TEST_F(BothWires, GiveARandomProgramTheSameAnswersTheSameAxesAndTheSameJournal) {
  {
    test::RunningService running("--clock lockstep --config " + std::string(kConfiguration) +
                                 " --axes " + std::to_string(kAxes) + " --state " +
                                 path("state.dds").string() + " --journal " +
                                 path("journal.dds").string());
    const Bench bench({.configuration_file = kConfiguration,
                       .axes = kAxes,
                       .clock = ClockMode::lockstep,
                       .state_directory = path("state.local"),
                       .journal = path("journal.local")});
    Session over_dds(test::options());
    Session local = bench.session();
    run_sequences(local, over_dds);
    ASSERT_EQ(running.stop().code, 0);
  }
  const auto local = records_of(path("journal.local"));
  const auto over_dds = records_of(path("journal.dds"));
  ASSERT_EQ(local.size(), over_dds.size());
  EXPECT_GT(local.size(), number_of_sequences());  // a snapshot each
  for (std::size_t i = 0; i < local.size(); ++i) {
    ASSERT_TRUE(local[i] == over_dds[i])
        << "record " << i << " of " << local.size() << ", of kind " << local[i].index();
  }
}

}  // namespace
}  // namespace vdrive::bench
