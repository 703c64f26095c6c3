// SPDX-License-Identifier: Apache-2.0
// The journal of a bench and its replay, without a network or a clock.
#include "journal/journal.hpp"

#include "base/event_codes.hpp"
#include "core/support/allocation_guard.hpp"
#include "journal/replay.hpp"
#include "service/engine_under_test.hpp"
#include "support/random_cases.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::test {
namespace {

using service::Journal;
using service::JournalChange;
using service::JournalCode;
using service::JournalEnd;
using service::JournalError;
using service::JournalReader;
using service::JournalRecord;
using service::JournalSink;
using service::JournalSnapshot;
using service::JournalTick;
using service::JournalWriter;
using service::ReplayResult;
using testing::HasSubstr;

/// A journal file, removed when this object is destroyed.
class JournalFile {
 public:
  JournalFile() {
    const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string("vdrive_") + test->test_suite_name() + "_" + test->name() + "_" +
                       std::to_string(::getpid());
    std::replace(name.begin(), name.end(), '/', '_');
    path_ = std::filesystem::temp_directory_path() / name;
    std::filesystem::remove(path_);
  }

  ~JournalFile() { std::filesystem::remove(path_); }

  JournalFile(const JournalFile&) = delete;
  JournalFile& operator=(const JournalFile&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  [[nodiscard]] std::string bytes() const {
    std::ifstream stream(path_, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

  void set_bytes(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
  }

 private:
  std::filesystem::path path_;
};

/// @return the text of the replay, or of the exception that it threw.
std::string failure_of(const JournalFile& file) {
  try {
    return "no failure: " + service::replay(file.path()).text;
  } catch (const JournalError& error) {
    return error.what();
  }
}

service::Configuration many_kinds(std::size_t axes) {
  auto configuration = bench_configuration(axes);
  configuration.name = "it's: a \"bench\"";  // needs quotes in YAML
  for (std::size_t axis = 0; axis < axes; ++axis) {
    auto& model = configuration.axes[axis].configuration.model;
    model.coupling = axis % 3 == 1 ? Coupling::two_inertia : Coupling::rigid;
    model.load_inertia = 1.0e-4 / 3.0 * static_cast<double>(1 + axis);  // not a short decimal
    configuration.axes[axis].configuration.initial_position = static_cast<int>(axis) * 1'000 - 7;
  }
  return configuration;
}

service::Configuration unwatched(service::ClockMode clock) {
  auto configuration = bench_configuration(2);
  configuration.clock = clock;
  configuration.watchdog.reset();
  return configuration;
}

/// A bench that writes a journal.
struct RecordedBench {
  explicit RecordedBench(const service::Configuration& configuration, JournalSink sink)
      : bench(configuration), journal(configuration, std::move(sink), bench.counters) {
    bench.engine.record_to(journal);
  }

  EngineUnderTest bench;
  Journal journal;  // destroyed first
};

/// Does a random action as a client; some are refused.
void act_randomly(EngineUnderTest& bench, Random& random) {
  const auto axis = static_cast<std::uint16_t>(1 + random.below(bench.configuration.axes.size()));
  const std::uint64_t session = random.one_in(4) ? kBob : kAlice;
  const std::vector<std::uint16_t> words{0x0F, 0x1F, 0x3F, 0x7F, 0x010F, 0x06, 0x02, 0x80, 0x00};
  const std::vector<std::uint16_t> objects{0x607A, 0x6081, 0x6083, 0x6084, 0x5E00, 0x5E01, 0x5E02,
                                           0x60E0, 0x3576, 0x6060, 0x605A, 0x6007, 0x60F2, 0x6041};
  switch (random.below(8)) {
    case 0:
      bench.acquire(session, {axis});
      break;
    case 1:
      bench.reply_to(bench.make_request(msg::RequestKind::release, session));
      break;
    case 2:
      bench.reply_to(bench.make_request(msg::RequestKind::power_cycle, session, {axis}));
      break;
    case 3: {  // if one register is refused, none is written
      auto frame = bench.make_frame(session);
      frame.flags = msg::FRAME_ALL_OR_NOTHING;
      auto& command = add_command(frame, axis);
      command.members = msg::HAS_PROFILE_VELOCITY | msg::HAS_OP_MODE_CMD;
      command.profile_velocity = static_cast<std::uint32_t>(random.below(5'000));
      command.op_mode_cmd = random.one_in(2) ? 1 : 99;
      set_controlword(command, words[random.below(words.size())]);
      bench.receive(frame);
      break;
    }
    case 4:
    case 5:
      bench.write(session, axis, objects[random.below(objects.size())],
                  static_cast<std::int32_t>(random.word()) % 20'000);
      break;
    default:
      bench.write(session, axis, 0x6060, 1);
      bench.write(session, axis, 0x6040, words[random.below(words.size())]);
      break;
  }
  while (bench.outbox.command_replies.front() != nullptr) bench.outbox.command_replies.pop();
}

/// Runs the bench for `ticks` ticks with random actions; takes and restores snapshots.
void record_randomly(RecordedBench& recorded, std::uint64_t seed, std::uint64_t ticks) {
  Random random(seed);
  auto& bench = recorded.bench;
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    for (std::uint64_t action = random.below(4); action > 0; --action) act_randomly(bench, random);
    if (random.one_in(100)) {
      bench.reply_to(bench.make_request(msg::RequestKind::take_snapshot, kAlice));
      auto restore = bench.make_request(msg::RequestKind::restore_snapshot, kAlice);
      restore.snapshot = 1 + random.below(8);
      bench.reply_to(restore);
    }
    // Now and then both sessions are silent for longer than the watchdog allows.
    bench.steps(random.one_in(50) ? 150 : 1);
    static_cast<void>(bench.events({}));
  }
}

ReplayResult replay_with(const JournalFile& file, std::uint32_t threads) {
  return service::replay(file.path(), {.threads = threads});
}

TEST(Journal, ReplaysEveryClientActionWithAnyNumberOfThreads) {
  for (std::uint64_t seed = 1; seed <= case_count(30, 300); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const JournalFile file;
    std::uint64_t ticks = 0;
    {
      RecordedBench recorded(many_kinds(1 + seed % 20), service::open_journal(file.path()));
      recorded.bench.engine.start_at(1'000'000 * seed);
      record_randomly(recorded, seed, 300);
      ticks = recorded.bench.engine.tick() - 1'000'000 * seed;
      recorded.journal.close();
      EXPECT_EQ(recorded.bench.counters.journal_losses.get(), 0U);
      EXPECT_EQ(recorded.bench.counters.journal_ticks.get(), ticks);
    }
    for (const std::uint32_t threads : {1U, 4U}) {
      const ReplayResult result = replay_with(file, threads);
      ASSERT_TRUE(result.agrees) << result.text;
      EXPECT_TRUE(result.is_complete) << result.text;
      EXPECT_EQ(result.ticks, ticks);
      EXPECT_GT(result.changes, 0U);
    }
  }
}

TEST(Journal, RecordsNothingOfAFrameThatIsRefusedAsAWhole) {
  const JournalFile file;
  {
    RecordedBench recorded(unwatched(service::ClockMode::lockstep),
                           service::open_journal(file.path()));
    auto& bench = recorded.bench;
    bench.acquire(kAlice, {1});
    auto frame = bench.make_frame(kAlice);
    frame.flags = msg::FRAME_ALL_OR_NOTHING;
    auto& command = add_command(frame, 1);
    command.members = msg::HAS_PROFILE_VELOCITY;
    command.profile_velocity = 10;
    auto& refused = command.objects.emplace_back();  // applied after the members
    refused.index = 0x6041;
    bench.receive(frame);
    ASSERT_EQ(bench.command_reply()->refusals.size(), 1U);
    bench.write(kAlice, 1, 0x6060, 1);
    bench.write(kAlice, 1, 0x607A, 10'000);
    bench.write(kAlice, 1, 0x6040, 0x0F);
    bench.write(kAlice, 1, 0x6040, 0x3F);
    bench.steps(100);  // much faster than 10 UU/s
    ASSERT_GT(bench.value(1, 0x6062), 10);
  }
  const ReplayResult result = replay_with(file, 1);
  EXPECT_TRUE(result.agrees && result.is_complete) << result.text;
  EXPECT_EQ(result.changes, 4U) << "those of the move";
}

TEST(Journal, RecordsLostMastersAndPowerCycles) {
  const JournalFile file;
  {
    RecordedBench recorded(bench_configuration(3), service::open_journal(file.path()));
    auto& bench = recorded.bench;
    bench.write(kAlice, 2, 0x6040, 0x0F);
    bench.steps(200);  // the watchdog waits for 100
    ASSERT_EQ(bench.value(2, 0x603F), 0x8130);
    ASSERT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::power_cycle, kBob, {2})).reason,
              msg::Reason::none);
    bench.steps(10);
    ASSERT_EQ(bench.value(2, 0x603F), 0);
  }
  const ReplayResult result = replay_with(file, 1);
  EXPECT_TRUE(result.agrees && result.is_complete) << result.text;
  EXPECT_EQ(result.changes, 3U);
}

TEST(Journal, RecordsAConnectionThatTheTestBenchLosesAndAnInterpolation) {
  const JournalFile file;
  {
    RecordedBench recorded(unwatched(service::ClockMode::lockstep),
                           service::open_journal(file.path()));
    auto& bench = recorded.bench;
    bench.write(kAlice, 1, 0x60C2, 50, 1);
    bench.write(kAlice, 1, 0x6060, 8);
    bench.write(kAlice, 1, 0x6040, 0x0F);
    bench.steps(2);
    bench.write(kAlice, 1, 0x607A, 1'000);
    bench.steps(25);
    ASSERT_EQ(bench.value(1, 0x6062), 500);
    bench.write(kBob, 1, 0x5E0A, 1);
    bench.steps(200);
    ASSERT_EQ(bench.value(1, 0x603F), 0x8130);
  }
  const ReplayResult result = replay_with(file, 1);
  EXPECT_TRUE(result.agrees && result.is_complete) << result.text;
  EXPECT_EQ(result.changes, 5U);
}

TEST(Journal, RecordsTheHabitsOfADrive) {
  const JournalFile file;
  {
    RecordedBench recorded(unwatched(service::ClockMode::lockstep),
                           service::open_journal(file.path()));
    auto& bench = recorded.bench;
    bench.write(kBob, 1, 0x5E20, 20, 7);  // habit_power_on_time
    bench.write(kAlice, 1, 0x6040, 0x0F);
    bench.steps(10);
    ASSERT_EQ(bench.value(1, 0x6041) & 0x6F, 0x23) << "Switched on";
    bench.steps(20);
    ASSERT_EQ(bench.value(1, 0x6041) & 0x6F, 0x27) << "Operation enabled";
  }
  const ReplayResult result = replay_with(file, 1);
  EXPECT_TRUE(result.agrees && result.is_complete) << result.text;
  EXPECT_EQ(result.changes, 2U);
}

TEST(Journal, RecordsHowTheAxesOfAnEndingBenchComeToRest) {
  const JournalFile file;
  {
    RecordedBench recorded(unwatched(service::ClockMode::freerun),
                           service::open_journal(file.path()));
    auto& bench = recorded.bench;
    bench.write(kAlice, 1, 0x6060, 1);
    bench.write(kAlice, 1, 0x607A, 1'000'000);
    bench.write(kAlice, 1, 0x6040, 0x0F);
    bench.steps(2);
    bench.write(kAlice, 1, 0x6040, 0x1F);
    bench.steps(50);
    bench.engine.shut_down(service::Braking::ramp);
    bench.steps(200);
    ASSERT_FALSE(bench.engine.has_power());
  }
  const ReplayResult result = replay_with(file, 1);
  EXPECT_TRUE(result.agrees && result.is_complete) << result.text;
  EXPECT_EQ(result.changes, 6U) << "four of the client, Disable operation, Disable voltage";
}

TEST(Journal, HasTheSameContentWithEveryClock) {
  for (const auto clock : {service::ClockMode::lockstep, service::ClockMode::realtime}) {
    const JournalFile file;
    auto configuration = many_kinds(5);
    configuration.clock = clock;
    {
      RecordedBench recorded(configuration, service::open_journal(file.path()));
      recorded.bench.write(kAlice, 1, 0x6040, 0x0F);
      recorded.bench.steps(20);
      recorded.bench.engine.jump(500);
      recorded.bench.steps(300);  // the watchdog fires
    }
    const ReplayResult result = replay_with(file, 1);
    EXPECT_TRUE(result.agrees && result.is_complete) << result.text;
    EXPECT_EQ(result.ticks, 320U);
  }
}

/// Rewrites a journal, with `alter` applied to each change.
template <typename Alter>
void rewrite(const JournalFile& file, Alter alter) {
  std::istringstream bytes(file.bytes());
  std::ostringstream altered;
  JournalReader reader(bytes);
  JournalWriter writer(
      [&](std::span<const std::byte> part) {
        for (const std::byte byte : part) altered.put(static_cast<char>(byte));
      },
      reader.start());
  while (const auto record = reader.next()) {
    if (const auto* const change = std::get_if<JournalChange>(&*record)) {
      JournalChange other = *change;
      alter(other);
      writer.write(other);
    } else if (const auto* const tick = std::get_if<JournalTick>(&*record)) {
      writer.write_tick(tick->number, tick->digest, tick->rows);
    } else if (const auto* const snapshot = std::get_if<JournalSnapshot>(&*record)) {
      writer.write(*snapshot);
    } else if (std::holds_alternative<JournalEnd>(*record)) {
      writer.end();
    }
  }
  file.set_bytes(altered.str());
}

/// Records 2000 ticks of three axes, of which axis 2 moves to 10000 from tick 3 on.
void record_move(const JournalFile& file) {
  auto configuration = bench_configuration(3);
  configuration.watchdog.reset();
  RecordedBench recorded(configuration, service::open_journal(file.path()));
  auto& bench = recorded.bench;
  bench.write(kAlice, 2, 0x6060, 1);
  bench.write(kAlice, 2, 0x6081, 1'000);
  bench.write(kAlice, 2, 0x6040, 0x0F);
  bench.steps(2);
  bench.write(kAlice, 2, 0x607A, 10'000);
  bench.write(kAlice, 2, 0x6040, 0x3F);
  bench.steps(2'000);
}

TEST(Replay, ReplaysACopyOfAJournal) {
  const JournalFile file;
  record_move(file);
  rewrite(file, [](JournalChange&) {});
  const ReplayResult result = replay_with(file, 1);
  EXPECT_TRUE(result.agrees && result.is_complete) << result.text;
  EXPECT_EQ(result.ticks, 2'002U);
  EXPECT_EQ(result.changes, 5U);
}

TEST(Replay, NamesTickAxisAndMemberOfTheFirstDifference) {
  const JournalFile file;
  record_move(file);
  rewrite(file, [](JournalChange& change) {
    if (change.value == 0x0F) change.value = 0x06;
  });
  // In the first tick, 0x06 leads to Ready to switch on (lower byte 0x31) instead of Operation
  // enabled. Nothing has moved yet, so the statusword is the first member to differ.
  const ReplayResult result = replay_with(file, 1);
  EXPECT_FALSE(result.agrees);
  EXPECT_THAT(result.text,
              HasSubstr("tick 1: axis 2 (axis2), member ds402_statusword (6041h): replayed "));
}

/// Steps the original and the altered bank side by side: an oracle that needs no journal.
TEST(Replay, FindsTheSameDifferenceAsTwoBanksInParallel) {
  const JournalFile file;
  record_move(file);
  rewrite(file, [](JournalChange& change) {
    if (change.address == ObjectAddress{0x6081, 0}) change.value = 999;
  });
  const auto axes = service::bank_axes(bench_configuration(3));
  AxisBank recorded(axes, std::chrono::milliseconds{1});
  AxisBank altered(axes, std::chrono::milliseconds{1});
  for (auto* const bank : {&recorded, &altered}) {
    bank->write(1, {0x6060, 0}, 1);
    bank->write(1, {0x6081, 0}, bank == &altered ? 999 : 1'000);
    bank->write(1, {0x6040, 0}, 0x0F);
  }
  std::uint64_t tick = 0;
  std::string expected;
  while (expected.empty()) {
    ASSERT_LT(tick, 2'002U);
    recorded.step();
    altered.step();
    ++tick;
    if (tick == 2) {
      for (auto* const bank : {&recorded, &altered}) {
        bank->write(1, {0x607A, 0}, 10'000);
        bank->write(1, {0x6040, 0}, 0x3F);
      }
    }
    for (const StatusMember& member : status_members()) {
      const std::int64_t value = member.value(altered.status(1));
      if (expected.empty() && value != member.value(recorded.status(1))) {
        expected =
            "tick " + std::to_string(tick) + ": axis 2 (axis2), member " + std::string(member.name);
      }
    }
  }
  ASSERT_GT(tick, 3U);
  EXPECT_THAT(replay_with(file, 1).text, HasSubstr(expected + " "));
}

TEST(Replay, NamesTheGroupOfAxesOnALargeBench) {
  const JournalFile file;
  {
    auto configuration = bench_configuration(300);
    configuration.watchdog.reset();
    RecordedBench recorded(configuration, service::open_journal(file.path()));
    recorded.bench.write(kAlice, 100, 0x6040, 0x0F);
    recorded.bench.steps(3);
  }
  rewrite(file, [](JournalChange& change) {
    change.value = 0x06;
  });
  // Above 256 axes a row covers 64 axes; axis 100 is in the second row.
  EXPECT_THAT(replay_with(file, 4).text,
              HasSubstr("tick 1: one of axis 65 (axis65) to axis 128 (axis128), member "
                        "ds402_statusword (6041h)"));
}

TEST(Replay, ReportsARecordedWriteThatIsNowRefused) {
  const JournalFile file;
  record_move(file);
  rewrite(file, [](JournalChange& change) {
    if (change.address == ObjectAddress{0x6081, 0}) change.address.index = 0x6041;
  });
  EXPECT_THAT(replay_with(file, 1).text, HasSubstr("tick 1: axis 2 (axis2): the write of 1000 to "
                                                   "ds402_statusword (6041h) was accepted when it "
                                                   "was recorded and is refused now"));
}

// ---- damaged files ---------------------------------------------------------------------------

/// FNV-1a over 64-bit words, the last one padded with zeros (docs/reference/journal.md).
std::uint64_t fnv(std::string_view bytes) {
  std::uint64_t check = 14695981039346656037ULL;
  for (std::size_t position = 0; position < bytes.size(); position += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + position, std::min<std::size_t>(8, bytes.size() - position));
    check = (check ^ word) * 1099511628211ULL;
  }
  return check;
}

template <typename Number>
Number number_at(const std::string& bytes, std::size_t place) {
  Number number{};
  std::memcpy(&number, bytes.data() + place, sizeof(number));
  return number;
}

template <typename Number>
void put_number(std::string& bytes, std::size_t place, Number number) {
  std::memcpy(bytes.data() + place, &number, sizeof(number));
}

constexpr std::size_t kHead = 24;  // [bytes] of a chunk

/// @return the offset of the chunk after the one at `chunk`.
std::size_t chunk_after(const std::string& bytes, std::size_t chunk) {
  return chunk + kHead + number_at<std::uint32_t>(bytes, chunk + 4);
}

/// Makes the head's checksum match the three words before it.
void seal_head(std::string& bytes, std::size_t chunk) {
  const std::uint64_t check = fnv(std::string_view(bytes).substr(chunk, 12));
  put_number(bytes, chunk + 12, static_cast<std::uint32_t>(check ^ (check >> 32U)));
}

/// Makes the content's checksum match.
void seal_content(std::string& bytes, std::size_t chunk) {
  const auto length = number_at<std::uint32_t>(bytes, chunk + 4);
  put_number(bytes, chunk + 16, fnv(std::string_view(bytes).substr(chunk + kHead, length)));
}

TEST(DamagedJournal, ReplaysUpToItsTruncation) {
  const JournalFile file;
  record_move(file);
  const std::string whole = file.bytes();
  for (const double part : {0.5, 0.8, 0.99}) {
    const auto size = static_cast<std::size_t>(static_cast<double>(whole.size()) * part);
    file.set_bytes(whole.substr(0, size));
    const ReplayResult result = replay_with(file, 1);
    EXPECT_TRUE(result.agrees) << result.text;
    EXPECT_FALSE(result.is_complete) << result.text;
    EXPECT_LT(result.ticks, 2'002U);
    const std::string early =
        "the journal ends early, without an end mark: " + std::to_string(result.ticks) +
        " of at least ";
    ASSERT_THAT(result.text, HasSubstr(early));
    EXPECT_THAT(result.text, HasSubstr("of an unfinished chunk"));
    // 2,002 ticks were recorded. Those in the unfinished chunk are visible but not reliable.
    const auto seen = std::stoull(result.text.substr(result.text.find(early) + early.size()));
    EXPECT_GT(seen, result.ticks);
    EXPECT_LE(seen, 2'002U);
  }
}

TEST(DamagedJournal, WithoutItsEndIsIncompleteEvenAfterAWholeChunk) {
  const JournalFile file;
  record_move(file);
  const std::string whole = file.bytes();
  file.set_bytes(whole.substr(0, whole.size() - kHead - 24));  // three numbers of 8 bytes
  const ReplayResult result = replay_with(file, 1);
  EXPECT_TRUE(result.agrees) << result.text;
  EXPECT_FALSE(result.is_complete);
  EXPECT_THAT(result.text, HasSubstr("2002 of at least 2002 ticks were replayed, up to tick 2002"));
}

TEST(DamagedJournal, IsRefusedWithDataAfterItsEnd) {
  const JournalFile file;
  record_move(file);
  const std::string whole = file.bytes();
  const std::size_t last = whole.size() - kHead - 24;
  std::string second_end = whole.substr(last);
  put_number(second_end, 8, number_at<std::uint32_t>(whole, last + 8) + 1);
  seal_head(second_end, 0);
  for (const std::string& tail : {std::string("x"), second_end}) {
    file.set_bytes(whole + tail);
    EXPECT_THAT(failure_of(file), HasSubstr("data after its end mark"));
  }
}

// The start record holds 28 bytes of numbers, then the length of the first text. The chunks are
// start, snapshot, records.
TEST(DamagedJournal, WithAForgedLengthIsRefusedWithoutItsAllocation) {
  const JournalFile file;
  record_move(file);
  const std::string whole = file.bytes();
  std::size_t chunk = 0;
  for (const std::uint32_t kind : {1U, 3U, 2U}) {
    ASSERT_EQ(number_at<std::uint32_t>(whole, chunk), kind);
    std::string forged = whole;
    put_number(forged, chunk + 4, 0xFFFFFFF0U);
    seal_head(forged, chunk);
    file.set_bytes(forged);
    EXPECT_THAT(failure_of(file), HasSubstr("byte " + std::to_string(chunk) + ": a chunk of kind " +
                                            std::to_string(kind) + " with 4294967280 bytes"));
    chunk = chunk_after(whole, chunk);
  }
  std::string text = whole;
  put_number(text, kHead + 28, 0xFFFFFFF0U);
  seal_content(text, 0);
  file.set_bytes(text);
  EXPECT_THAT(failure_of(file), HasSubstr("byte 0: a text of 4294967280 bytes is incomplete"));
}

// A snapshot of many axes could be 200 MiB long, but this file is shorter, so it is truncated.
TEST(DamagedJournal, AllocatesNothingForAChunkBeyondTheFile) {
  const JournalFile file;
  record_move(file);
  std::string forged = file.bytes();
  const std::size_t snapshot = chunk_after(forged, 0);
  put_number(forged, snapshot + 4, 200U << 20U);
  seal_head(forged, snapshot);
  file.set_bytes(forged);
  rusage before{};
  rusage after{};
  getrusage(RUSAGE_SELF, &before);
  const ReplayResult result = replay_with(file, 1);
  getrusage(RUSAGE_SELF, &after);
  EXPECT_FALSE(result.is_complete);
  EXPECT_EQ(result.ticks, 0U);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 100'000) << "KiB";
}

TEST(DamagedJournal, RefusesUnknownContent) {
  const JournalFile file;
  record_move(file);
  const std::string whole = file.bytes();
  const std::size_t snapshot = chunk_after(whole, 0);
  std::string kind = whole;
  put_number(kind, snapshot, 9U);
  seal_head(kind, snapshot);
  file.set_bytes(kind);
  EXPECT_THAT(failure_of(file), HasSubstr("unknown kind of chunk: 9"));
  std::string cause = whole;
  cause[snapshot + kHead] = 4;
  seal_content(cause, snapshot);
  file.set_bytes(cause);
  EXPECT_THAT(failure_of(file), HasSubstr("unknown cause of a snapshot: 4"));
}

// Older versions wrote the empty credential directory of an open bench.
TEST(Replay, AcceptsOlderJournalsWithAnEmptyDirectory) {
  const JournalFile file;
  record_move(file);
  const std::string whole = file.bytes();
  const std::size_t end = chunk_after(whole, 0);
  std::string start = whole.substr(0, end);
  const std::string key = "\n  security: \"\"";
  const std::size_t place = start.find("\naxes:");
  ASSERT_NE(place, std::string::npos);
  start.insert(place, key);
  const auto added = static_cast<std::uint32_t>(key.size());
  const std::size_t version = number_at<std::uint32_t>(start, kHead + 28);
  const std::size_t length = kHead + 28 + 4 + version;  // of the configuration
  put_number(start, length, number_at<std::uint32_t>(start, length) + added);
  put_number(start, 4, number_at<std::uint32_t>(start, 4) + added);
  seal_head(start, 0);
  seal_content(start, 0);
  file.set_bytes(start + whole.substr(end));
  const ReplayResult result = replay_with(file, 1);
  EXPECT_TRUE(result.agrees && result.is_complete) << result.text;
}

TEST(DamagedJournal, NamesThePlaceOfAnyFlippedBit) {
  const JournalFile file;
  record_move(file);
  const std::string whole = file.bytes();
  Random random(3);
  for (int number = 0; number < 40; ++number) {
    std::string damaged = whole;
    const std::size_t place = random.below(whole.size());
    damaged[place] = static_cast<char>(damaged[place] ^ (1 << random.below(8)));
    file.set_bytes(damaged);
    const std::string failure = failure_of(file);
    ASSERT_THAT(failure, testing::ContainsRegex("byte [0-9]+: "))
        << "byte " << place << ": " << failure;
    // The message names the offset of the damaged chunk.
    const auto named = std::stoull(failure.substr(failure.find(": byte ") + 7));
    EXPECT_LE(named, place);
  }
}

TEST(DamagedJournal, ReportsAMissingChunk) {
  const JournalFile file;
  record_move(file);
  const std::string whole = file.bytes();
  const std::size_t second = chunk_after(whole, 0);
  file.set_bytes(whole.substr(0, second) + whole.substr(chunk_after(whole, second)));
  EXPECT_THAT(failure_of(file), HasSubstr("chunk 2 was found, expected chunk 1"));
}

TEST(DamagedJournal, RefusesAnotherFileFormat) {
  const JournalFile file;
  for (const char* const text :
       {"", "vdrvjrnl", "this is a text with more than twenty-four bytes"}) {
    file.set_bytes(text);
    EXPECT_THAT(failure_of(file), HasSubstr("this is not a journal")) << text;
  }
  EXPECT_THROW(static_cast<void>(service::replay("/nonexistent/journal")), JournalError);
}

TEST(DamagedJournal, RefusesAnotherVersionOfTheFormat) {
  const JournalFile file;
  record_move(file);
  std::string bytes = file.bytes();
  // The version follows the head of the chunk (24 bytes) and the magic (8 bytes). The checksums are
  // made to match, as a newer writer would have them.
  bytes[32] = 3;
  seal_content(bytes, 0);
  file.set_bytes(bytes);
  EXPECT_THAT(failure_of(file),
              HasSubstr("version 3 of the format is not supported; supported: 1 to 2"));
}

TEST(DamagedJournal, RefusesAnotherLayoutOfTheState) {
  const JournalFile file;
  record_move(file);
  std::istringstream bytes(file.bytes());
  service::JournalStart start = JournalReader(bytes).start();
  start.layout ^= 1U;
  start.version = "9.9";
  {
    const JournalSink sink = [&](std::span<const std::byte> part) {
      file.set_bytes({reinterpret_cast<const char*>(part.data()), part.size()});  // NOLINT
    };
    JournalWriter writer(sink, start);
  }
  EXPECT_THAT(failure_of(file),
              HasSubstr("it was written by vdrived 9.9, whose state has a different layout"));
}

TEST(Journal, DoesNotOverwriteAFile) {
  const JournalFile file;
  file.set_bytes("x");
  EXPECT_THROW(static_cast<void>(service::open_journal(file.path())), service::ConfigurationError);
  EXPECT_EQ(file.bytes(), "x");
}

// ---- slow and full disks ---------------------------------------------------------------------

/// Wraps a sink so that it can be blocked.
class Gate {
 public:
  void close() {
    const std::lock_guard lock(mutex_);
    open_ = false;
  }

  void open() {
    {
      const std::lock_guard lock(mutex_);
      open_ = true;
    }
    changed_.notify_all();
  }

  [[nodiscard]] JournalSink around(JournalSink sink) {
    return [this, sink = std::move(sink)](std::span<const std::byte> bytes) {
      {
        std::unique_lock lock(mutex_);
        waiting_ = !open_;
        changed_.notify_all();
        changed_.wait(lock, [this] {
          return open_;
        });
        waiting_ = false;
      }
      sink(bytes);
    };
  }

  /// Waits until the writer is blocked by the gate.
  void wait_for_writer() {
    std::unique_lock lock(mutex_);
    ASSERT_TRUE(changed_.wait_for(lock, std::chrono::seconds(60), [this] {
      return waiting_;
    }));
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = true;
  bool waiting_ = false;
};

/// Starts a move of every axis that outlasts any test, so every tick has data to record.
void start_moving(EngineUnderTest& bench) {
  for (const auto& axis : bench.configuration.axes) {
    bench.write(kAlice, axis.number, 0x6060, 1);
    bench.write(kAlice, axis.number, 0x6081, 1'000);
    bench.write(kAlice, axis.number, 0x607A, 2'000'000'000);
    bench.write(kAlice, axis.number, 0x6040, 0x0F);
    bench.write(kAlice, axis.number, 0x6040, 0x3F);
  }
}

/// A record takes 109 bytes here (kind, image, 23 members, 2 rows), and the writer gets 64 KiB at a
/// time: with the gate closed it stops after 602 ticks, and kSlots more fit into the queue.
constexpr std::uint64_t kTicksBeforeGate = 602;

TEST(SlowJournal, StopsAClockThatCanWaitAndLosesNothing) {
  const JournalFile file;
  Gate gate;
  constexpr std::uint64_t kTicks = 3 * Journal::kSlots;
  {
    RecordedBench recorded(unwatched(service::ClockMode::lockstep),
                           gate.around(service::open_journal(file.path())));
    start_moving(recorded.bench);
    gate.close();
    std::thread clock([&] {
      recorded.bench.steps(kTicks);
    });
    gate.wait_for_writer();
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (recorded.bench.counters.tick.get() < Journal::kSlots &&
           std::chrono::steady_clock::now() < deadline) {
      std::this_thread::yield();
    }
    EXPECT_GE(recorded.bench.counters.tick.get(), Journal::kSlots);
    EXPECT_LE(recorded.bench.counters.tick.get(), Journal::kSlots + kTicksBeforeGate + 2);
    gate.open();
    clock.join();
    EXPECT_EQ(recorded.bench.counters.journal_losses.get(), 0U);
  }
  const ReplayResult result = replay_with(file, 1);
  EXPECT_TRUE(result.agrees && result.is_complete) << result.text;
  EXPECT_EQ(result.ticks, kTicks);
}

TEST(SlowJournal, LosesWholeTicksOfTheWallClockReportsAndContinues) {
  const JournalFile file;
  Gate gate;
  {
    RecordedBench recorded(unwatched(service::ClockMode::realtime),
                           gate.around(service::open_journal(file.path())));
    auto& bench = recorded.bench;
    start_moving(bench);
    gate.close();
    bench.steps(kTicksBeforeGate + 2);
    gate.wait_for_writer();
    bench.steps(Journal::kSlots + 1'000);
    const auto begun = bench.events(msg::EventKind::journal);
    ASSERT_EQ(begun.size(), 1U);
    EXPECT_EQ(begun[0].code, JournalCode::kLosing);
    EXPECT_GE(bench.counters.journal_losses.get(), 1'000U - 2U);
    EXPECT_LE(bench.counters.journal_losses.get(), 1'002U + kTicksBeforeGate);
    bench.write(kAlice, 1, 0x6081, 500);  // missing from the journal's records, but in its snapshot
    gate.open();
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    std::vector<service::EventRecord> resumed;
    while (resumed.empty() && std::chrono::steady_clock::now() < deadline) {
      bench.steps(1);
      resumed = bench.events(msg::EventKind::journal);
    }
    ASSERT_EQ(resumed.size(), 1U);
    EXPECT_EQ(resumed[0].code, JournalCode::kResumed);
    EXPECT_EQ(resumed[0].detail,
              service::EventDetail{service::Count{bench.counters.journal_losses.get()}});
    bench.steps(100);
    recorded.journal.close();
    EXPECT_EQ(bench.counters.journal_ticks.get() + bench.counters.journal_losses.get(),
              bench.engine.tick());
  }
  const ReplayResult result = replay_with(file, 1);
  EXPECT_TRUE(result.agrees) << result.text;
  EXPECT_FALSE(result.is_complete);
  EXPECT_THAT(result.text, HasSubstr(" ticks are missing: "));
}

TEST(FullDisk, EndsTheJournalOnly) {
  for (const auto clock : {service::ClockMode::lockstep, service::ClockMode::realtime}) {
    std::size_t taken = 0;
    const JournalSink sink = [&taken](std::span<const std::byte> bytes) {
      taken += bytes.size();
      if (taken > 100'000) throw std::system_error(ENOSPC, std::generic_category(), "disk");
    };
    RecordedBench recorded(unwatched(clock), sink);
    start_moving(recorded.bench);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    std::vector<service::EventRecord> events;
    while (events.empty() && std::chrono::steady_clock::now() < deadline) {
      recorded.bench.steps(10);
      events = recorded.bench.events(msg::EventKind::journal);
      std::erase_if(events, [](const auto& event) {  // a slow machine may lose some first
        return event.code != JournalCode::kEnded;
      });
    }
    ASSERT_EQ(events.size(), 1U);
    EXPECT_EQ(events[0].detail, service::EventDetail{service::SystemError{ENOSPC}});
    const auto before = recorded.bench.engine.tick();
    recorded.bench.steps(2 * Journal::kSlots);
    EXPECT_EQ(recorded.bench.engine.tick(), before + 2 * Journal::kSlots);
    EXPECT_TRUE(recorded.bench.events(msg::EventKind::journal).empty()) << "reported once";
  }
}

TEST(Journal, AllocatesNothingInTheTickThread) {
  const JournalFile file;
  Gate gate;
  RecordedBench recorded(unwatched(service::ClockMode::realtime),
                         gate.around(service::open_journal(file.path())));
  start_moving(recorded.bench);
  recorded.bench.steps(10);
  gate.close();
  const AllocationGuard guard;
  recorded.bench.steps(2 * Journal::kSlots);  // some are lost
  gate.open();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  const std::uint64_t lost = recorded.bench.counters.journal_losses.get();
  while (recorded.bench.counters.journal_ticks.get() < 2 * Journal::kSlots &&
         std::chrono::steady_clock::now() < deadline) {
    recorded.bench.steps(1);  // and takes the snapshot that follows the loss
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(lost, 0U);
}

#ifdef VDRIVE_REPLAY_PROGRAMS
TEST(Replay, AgreesInBuildsForOtherProcessorsAndInstructionSets) {
  // The features that x86-64-v3 adds to v2; clang 14 does not know the level's name here.
  const bool has_v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                      __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  if (!has_v3) GTEST_SKIP() << "this processor cannot run them";
  const JournalFile file;
  {
    RecordedBench recorded(many_kinds(30), service::open_journal(file.path()));
    record_randomly(recorded, 99, 1'000);
  }
  std::istringstream programs(VDRIVE_REPLAY_PROGRAMS);
  int count = 0;
  for (std::string program; std::getline(programs, program, ':'); ++count) {
    const std::string command = program + " " + file.path().string();
    EXPECT_EQ(std::system(command.c_str()), 0) << command;  // NOLINT(*-mt-unsafe): one thread
  }
  EXPECT_EQ(count, 2);
}
#endif

}  // namespace
}  // namespace vdrive::test
