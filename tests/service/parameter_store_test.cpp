// SPDX-License-Identifier: Apache-2.0
// Stored parameters on a disk, and what is loaded after any damage to the files.
#include "store/parameter_store.hpp"

#include "base/event_codes.hpp"
#include "service/failing_files.hpp"
#include "store/parameter_file.hpp"
#include "support/effort.hpp"
#include "support/temporary_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace vdrive::test {
namespace {

namespace fs = std::filesystem;
using service::apply;
using service::ConfigurationError;
using service::decode;
using service::encode;
using service::LoadedParameters;
using service::ParameterCode;
using service::ParameterFileError;
using service::ParameterProblem;
using service::ParameterStore;
using service::ParameterTable;
using Source = LoadedParameters::Source;

constexpr std::uint32_t kBenchOfStore = 7;
constexpr std::uintmax_t kLegible = 1U << 20U;  // larger files are compared by size
constexpr ObjectAddress kStoredVelocity{0x6081, 0};
constexpr ObjectAddress kLowerLimit{0x607D, 1};

/// @return a table of axes 1 and 2 whose values encode the generation.
ParameterTable table_of(std::int64_t generation) {
  return {{1, {{kLowerLimit, -generation}, {kStoredVelocity, generation}}},
          {2, {{kStoredVelocity, 5}}}};
}

/// @return the generation of the table if it is complete and made by `table_of`.
std::optional<std::int64_t> generation_of(const ParameterTable& table) {
  const auto axis = table.find(1);
  if (axis == table.end() || axis->second.size() != 2) return std::nullopt;
  const std::int64_t generation = axis->second[1].value;
  return encode(table) == encode(table_of(generation)) ? std::optional(generation) : std::nullopt;
}

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

// ---- the file --------------------------------------------------------------------------------

TEST(ParameterFile, IsReadBackUnchanged) {
  const ParameterTable table{
      {1, {{kLowerLimit, -2'147'483'648LL}, {kStoredVelocity, 4'294'967'295LL}}},
      {65'535, {{{0xFFFF, 255}, 0}}},
      {3, {}}};
  const std::string file = encode(table);
  EXPECT_EQ(encode(decode(bytes_of(file))), file);
  EXPECT_EQ(decode(bytes_of(file)).at(1)[0].value, -2'147'483'648LL);
  EXPECT_EQ(decode(bytes_of(file)).at(65'535)[0].address, (ObjectAddress{0xFFFF, 255}));
  EXPECT_TRUE(decode(bytes_of(encode({}))).empty());
}

TEST(ParameterFile, DetectsEveryChangedBit) {
  const std::string good = encode(table_of(100'000));
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    std::string file = good;
    file[bit / 8] = static_cast<char>(file[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_THROW((void)decode(bytes_of(file)), ParameterFileError) << "bit " << bit;
  }
}

TEST(ParameterFile, DetectsEveryTruncationAndExtension) {
  const std::string good = encode(table_of(100'000));
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_THROW((void)decode(bytes_of(good.substr(0, size))), ParameterFileError) << size;
    const std::string holes = good.substr(0, size) + std::string(good.size() - size, '\0');
    EXPECT_THROW((void)decode(bytes_of(holes)), ParameterFileError) << size;
  }
  EXPECT_THROW((void)decode(bytes_of(good + '\n')), ParameterFileError);
  EXPECT_THROW((void)decode(bytes_of(good + good)), ParameterFileError);
}

/// @return the file with its content changed and a matching checksum.
std::string forged(const std::string& file, const std::string& from, const std::string& to) {
  std::string content = file.substr(file.find('\n') + 1);
  content.replace(content.find(from), from.size(), to);
  std::uint64_t check =
      14695981039346656037ULL;  // FNV-1a over words, as in docs/reference/journal.md
  for (std::size_t place = 0; place < content.size(); place += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, content.data() + place, std::min(sizeof(word), content.size() - place));
    check = (check ^ word) * 1099511628211ULL;
  }
  std::ostringstream head;
  head << "vdrive parameters, version 1, " << content.size() << " bytes, check " << std::hex
       << std::setfill('0') << std::setw(16) << check << '\n';
  return head.str() + content;
}

// The JSON parser turns these into integers.
TEST(ParameterFile, WithACorrectChecksumIsDamagedByAnInvalidValue) {
  const std::string good = encode({{1, {{kStoredVelocity, 1}}}});
  ASSERT_EQ(forged(good, ": 1", ": 1"), good) << "the check of this test is right";
  for (const char* const value :
       {"1.5", "1.0", "1e0", "1e3", "true", "false", "null", "\"1\"", "[1]", "01", "+1",
        "18446744073709551617", "9223372036854775808", "1e400", "-0"}) {
    EXPECT_THROW((void)decode(bytes_of(forged(good, ": 1", ": " + std::string(value)))),
                 ParameterFileError)
        << value;
  }
}

TEST(ParameterFile, WithACorrectChecksumIsDamagedByAnInvalidForm) {
  const std::string good = encode({{1, {{kStoredVelocity, 1}}}});
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"\"1\"", "\"01\""},              // another spelling of axis 1
           {"\"1\"", "\"0x1\""},             // another spelling
           {"\"1\"", "\"65537\""},           // no axis has this number
           {"0x6081", "0x16081"},            // no object has this index
           {": 1", ": 1, \"0x6081:0\": 2"},  // an object twice
           {"{", "{\"more\": 1, "},
           {"\n}", "\n} "}}) {
    EXPECT_THROW((void)decode(bytes_of(forged(good, from, to))), ParameterFileError) << to;
  }
}

// ---- the store -------------------------------------------------------------------------------

class StateDirectory : public testing::Test {
 protected:
  [[nodiscard]] fs::path file(const std::string& suffix = "") const {
    return directory.path() / ("bench-7.parameters" + suffix);
  }

  [[nodiscard]] std::unique_ptr<ParameterStore> open() {
    return std::make_unique<ParameterStore>(directory.path(), kBenchOfStore,
                                            std::make_unique<FailingFiles>(plan));
  }

  /// Saves as a service that runs and ends. @return the parameters loaded before.
  LoadedParameters save(std::int64_t generation) {
    const auto store = open();
    LoadedParameters loaded = store->load();
    store->save(table_of(generation));
    return loaded;
  }

  LoadedParameters load() { return open()->load(); }

  TemporaryDirectory directory;
  FilePlan plan;
};

TEST_F(StateDirectory, IsEmptyAtFirst) {
  const LoadedParameters loaded = load();
  EXPECT_EQ(loaded.source, Source::nothing);
  EXPECT_EQ(loaded.problem, ParameterProblem::none);
  EXPECT_FALSE(fs::exists(file()));
}

TEST_F(StateDirectory, ReturnsTheSavedSetAndKeepsThePreviousOne) {
  save(1);
  EXPECT_EQ(generation_of(load().table), 1);
  save(2);
  const LoadedParameters loaded = load();
  EXPECT_EQ(generation_of(loaded.table), 2);
  EXPECT_EQ(loaded.source, Source::current);
  EXPECT_EQ(loaded.problem, ParameterProblem::none);
  EXPECT_EQ(read_text(file(".previous")), encode(table_of(1)));
  EXPECT_FALSE(fs::exists(file(".new")));
  EXPECT_FALSE(fs::exists(file(".damaged")));
}

TEST_F(StateDirectory, IsCreatedIfOnlyItsLastPartIsMissing) {
  const fs::path made = directory.path() / "state";
  ParameterStore(made, kBenchOfStore).save(table_of(1));
  EXPECT_TRUE(fs::exists(made / "bench-7.parameters"));
  EXPECT_THROW(ParameterStore(directory.path() / "a" / "b", kBenchOfStore), ConfigurationError);
  write_text(directory.path() / "file", "x");
  EXPECT_THROW(ParameterStore(directory.path() / "file", kBenchOfStore), ConfigurationError);
}

TEST_F(StateDirectory, BelongsToOneServiceForEachBench) {
  const auto first = open();
  try {
    const auto second = open();
    ADD_FAILURE() << "two services would write one file";
  } catch (const ConfigurationError& error) {
    EXPECT_NE(std::string(error.what()).find("bench 7 are in use by process "), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("process " + std::to_string(getpid()) + " ("),
              std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find(") on this host; stop it"), std::string::npos)
        << error.what();
  }
  EXPECT_NO_THROW(ParameterStore(directory.path(), kBenchOfStore + 1));
}

/// A way to damage the file.
struct Damage {
  const char* name;
  ParameterProblem problem;
  void (*inflict)(const fs::path& file);
};

std::string name_of(const testing::TestParamInfo<Damage>& info) {
  return info.param.name;
}

const std::array<Damage, 8> kDamages{{
    {"empty", ParameterProblem::empty,
     [](const fs::path& file) {
       write_text(file, "");
     }},
    {"torn", ParameterProblem::damaged,
     [](const fs::path& file) {
       fs::resize_file(file, fs::file_size(file) / 2);
     }},
    {"flipped", ParameterProblem::damaged,
     [](const fs::path& file) {
       std::string text = read_text(file);
       text[text.size() - 9] = static_cast<char>(text[text.size() - 9] ^ 1);
       write_text(file, text);
     }},
    {"huge", ParameterProblem::too_large,
     [](const fs::path& file) {
       fs::resize_file(file, service::kLargestParameterFile + 1);  // sparse
     }},
    {"newer", ParameterProblem::unknown_version,
     [](const fs::path& file) {
       std::string text = read_text(file);
       write_text(file, text.replace(text.find("version 1"), 9, "version 2"));
     }},
    {"older", ParameterProblem::unknown_version,
     [](const fs::path& file) {
       std::string text = read_text(file);
       write_text(file, text.replace(text.find("version 1"), 9, "version 0"));
     }},
    {"foreign", ParameterProblem::damaged,
     [](const fs::path& file) {
       write_text(file, "{\"axes\": {}}\n");
     }},
    {"a_directory", ParameterProblem::unreadable,
     [](const fs::path& file) {
       fs::remove(file);
       fs::create_directory(file);
     }},
}};

class DamagedFile : public StateDirectory, public testing::WithParamInterface<Damage> {};

TEST_P(DamagedFile, IsKeptAsideAndThePreviousSetIsUsed) {
  save(1);
  save(2);
  GetParam().inflict(file());
  const bool is_directory = fs::is_directory(file());
  const auto size = is_directory ? 0 : fs::file_size(file());
  const bool is_legible = !is_directory && size < kLegible;
  const std::string damaged = is_legible ? read_text(file()) : "";
  const LoadedParameters loaded = load();
  EXPECT_EQ(loaded.problem, GetParam().problem);
  EXPECT_EQ(loaded.source, Source::previous);
  EXPECT_EQ(generation_of(loaded.table), 1);
  EXPECT_EQ(load().problem, GetParam().problem) << "until something is stored";
  EXPECT_EQ(save(3).problem, GetParam().problem);
  EXPECT_EQ(fs::is_directory(file(".damaged")), is_directory);
  EXPECT_EQ(is_directory ? 0 : fs::file_size(file(".damaged")), size);
  EXPECT_EQ(is_legible ? read_text(file(".damaged")) : "", damaged);
  EXPECT_EQ(read_text(file(".previous")), encode(table_of(1))) << "the last set that was good";
  EXPECT_EQ(load().problem, ParameterProblem::none);
  EXPECT_EQ(generation_of(load().table), 3);
}

TEST_P(DamagedFile, LeavesNoSetWithoutAPreviousOne) {
  save(1);
  GetParam().inflict(file());
  const LoadedParameters loaded = load();
  EXPECT_EQ(loaded.problem, GetParam().problem);
  EXPECT_EQ(loaded.source, Source::nothing);
  EXPECT_TRUE(loaded.table.empty());
}

TEST_P(DamagedFile, OfThePreviousSetHasNoEffectWhileTheNewestIsGood) {
  save(1);
  save(2);
  GetParam().inflict(file(".previous"));
  EXPECT_EQ(load().problem, ParameterProblem::none);
  EXPECT_EQ(generation_of(load().table), 2);
}

INSTANTIATE_TEST_SUITE_P(Parameters, DamagedFile, testing::ValuesIn(kDamages), name_of);

TEST_F(StateDirectory, WithAnUnreadableFileReturnsThePreviousSet) {
  save(1);
  save(2);
  const auto store = open();
  plan.set([](std::uint64_t number) {
    if (number == 1) fail_with(EACCES);
  });
  const LoadedParameters loaded = store->load();
  EXPECT_EQ(loaded.problem, ParameterProblem::unreadable);
  EXPECT_EQ(loaded.number, static_cast<std::uint64_t>(EACCES));
  EXPECT_EQ(generation_of(loaded.table), 1);
}

TEST_F(StateDirectory, ReportsAFileThatWasRemoved) {
  save(1);
  save(2);
  fs::remove(file());
  const LoadedParameters loaded = load();
  EXPECT_EQ(loaded.problem, ParameterProblem::missing);
  EXPECT_EQ(generation_of(loaded.table), 1);
  EXPECT_EQ(generation_of((save(3), load()).table), 3);
}

TEST_F(StateDirectory, ReportsNothingAfterAnInterruptedSave) {
  save(1);
  fs::rename(file(), file(".previous"));
  write_text(file(".new"), encode(table_of(2)));
  const LoadedParameters loaded = load();
  EXPECT_EQ(loaded.problem, ParameterProblem::none);
  EXPECT_EQ(generation_of(loaded.table), 1);
  EXPECT_EQ(generation_of((save(3), load()).table), 3);
  EXPECT_EQ(read_text(file(".previous")), encode(table_of(1)));
}

TEST_F(StateDirectory, IgnoresAnUnfinishedFile) {
  save(1);
  write_text(file(".new"), encode(table_of(2)).substr(0, 50));
  EXPECT_EQ(load().problem, ParameterProblem::none);
  EXPECT_EQ(generation_of(load().table), 1);
  EXPECT_EQ(generation_of((save(3), load()).table), 3);
  EXPECT_FALSE(fs::exists(file(".new")));
}

TEST_F(StateDirectory, ThatIsReadOnlyLoadsAndRefusesToSave) {
  save(1);
  fs::remove(directory.path() / "bench-7.lock");
  // File permissions do not bind root, so the test seam refuses every change.
  plan.set([](std::uint64_t number) {
    if (number == 5) fail_with(EROFS);  // the lock file, after four steps on the directory
  });
  const auto store = open();
  EXPECT_EQ(generation_of(store->load().table), 1);
  plan.set([](std::uint64_t number) {
    if (number == 1) fail_with(EROFS);
  });
  EXPECT_THROW(store->save(table_of(2)), std::system_error);
  EXPECT_EQ(generation_of(load().table), 1);
}

TEST_F(StateDirectory, ThatIsFullKeepsTheStoredSet) {
  save(1);
  const auto store = open();
  static_cast<void>(store->load());
  plan.set([](std::uint64_t number) {
    if (number == 3) fail_with(ENOSPC);  // the first write, after a check and an open
  });
  EXPECT_THROW(store->save(table_of(2)), std::system_error);
  plan.set({});
  EXPECT_FALSE(fs::exists(file(".new"))) << "its space is needed";
  EXPECT_EQ(generation_of(store->load().table), 1);
  EXPECT_NO_THROW(store->save(table_of(3))) << "there is room again";
  EXPECT_EQ(generation_of(store->load().table), 3);
}

// ---- every operation fails -------------------------------------------------------------------

/// The parameter: whether all later operations fail as well.
class FailingOperation : public StateDirectory, public testing::WithParamInterface<bool> {
 protected:
  /// Makes operation `first` fail, and all later ones if the parameter is true.
  void fail(std::uint64_t first) {
    plan.set([first, for_ever = GetParam()](std::uint64_t number) {
      if (number == first || (for_ever && number > first)) fail_with(EIO);
    });
  }

  /// @return whether the store reports success.
  bool tries_to_save(ParameterStore& store, std::int64_t generation, std::uint64_t first) {
    fail(first);
    try {
      store.save(table_of(generation));
    } catch (const std::system_error&) {
      return false;
    }
    return true;
  }
};

TEST_P(FailingOperation, OfASaveLeavesAWholeSetAndNeverLosesASavedOne) {
  bool has_failed = true;
  for (std::uint64_t first = 1; has_failed; ++first) {
    SCOPED_TRACE("operation " + std::to_string(first));
    save(1);
    save(2);
    auto store = open();
    ASSERT_EQ(generation_of(store->load().table), 2);
    const bool is_saved = tries_to_save(*store, 3, first);
    has_failed = plan.count >= first;
    EXPECT_TRUE(is_saved || has_failed);
    plan.set({});
    store.reset();
    const LoadedParameters loaded = load();
    EXPECT_EQ(loaded.problem, ParameterProblem::none);
    const auto generation = generation_of(loaded.table);
    // A set whose save has failed is loaded only if it could not be removed either.
    EXPECT_TRUE(generation == 3 ? is_saved || GetParam() : generation == 2 && !is_saved);
    save(4);
    EXPECT_EQ(generation_of(load().table), 4) << "once nothing fails any more";
  }
}

TEST_P(FailingOperation, OfTheFirstSaveLeavesNoRefusedSet) {
  bool has_failed = true;
  for (std::uint64_t first = 1; has_failed; ++first) {
    SCOPED_TRACE("operation " + std::to_string(first));
    for (const char* suffix : {"", ".new", ".previous"}) fs::remove(file(suffix));
    auto store = open();
    static_cast<void>(store->load());
    const bool is_saved = tries_to_save(*store, 1, first);
    has_failed = plan.count >= first;
    plan.set({});
    store.reset();
    const LoadedParameters loaded = load();
    EXPECT_EQ(loaded.problem, ParameterProblem::none);
    const bool is_there = loaded.source == Source::current;
    EXPECT_TRUE(is_there ? is_saved || GetParam() : !is_saved);
  }
}

TEST_P(FailingOperation, OfASaveOverADamagedFileKeepsTheDamageVisible) {
  bool has_failed = true;
  for (std::uint64_t first = 1; has_failed; ++first) {
    SCOPED_TRACE("operation " + std::to_string(first));
    save(1);
    save(2);
    write_text(file(), "damaged");
    auto store = open();
    static_cast<void>(store->load());
    const bool is_saved = tries_to_save(*store, 3, first);
    has_failed = plan.count >= first;
    plan.set({});
    store.reset();
    const LoadedParameters loaded = load();
    EXPECT_EQ(loaded.problem == ParameterProblem::none, loaded.source == Source::current);
    EXPECT_TRUE(loaded.source == Source::current ? is_saved || GetParam()
                                                 : !is_saved && generation_of(loaded.table) == 1);
    save(4);
    EXPECT_EQ(generation_of(load().table), 4) << "once nothing fails any more";
  }
}

TEST_P(FailingOperation, OfASaveHasNoEffectOnTheNextSave) {
  for (std::uint64_t first = 1; first < 40; ++first) {
    SCOPED_TRACE("operation " + std::to_string(first));
    save(1);
    const auto store = open();
    static_cast<void>(store->load());
    fail(first);
    try {
      store->save(table_of(2));
    } catch (const std::system_error&) {
      plan.set({});
    }
    plan.set({});
    store->save(table_of(3));
    const LoadedParameters loaded = store->load();
    EXPECT_EQ(loaded.problem, ParameterProblem::none);
    EXPECT_EQ(generation_of(loaded.table), 3);
  }
}

TEST_P(FailingOperation, OfASaveAfterAnInterruptedOneLosesNothing) {
  for (std::uint64_t first = 1; first < 40; ++first) {
    SCOPED_TRACE("operation " + std::to_string(first));
    save(1);
    fs::rename(file(), file(".previous"));
    write_text(file(".new"), encode(table_of(2)));
    auto store = open();
    ASSERT_EQ(generation_of(store->load().table), 1);
    fail(first);
    try {
      store->save(table_of(3));
    } catch (const std::system_error&) {
      plan.set({});
    }
    plan.set({});
    store.reset();
    const LoadedParameters loaded = load();
    EXPECT_EQ(loaded.problem, ParameterProblem::none);
    const auto generation = generation_of(loaded.table);
    EXPECT_TRUE(generation == 1 || generation == 3);
  }
}

TEST_P(FailingOperation, OfALoadReturnsAWholeSetOrNoneAndChangesNone) {
  save(1);
  save(2);
  std::uint64_t operations = 1;
  for (std::uint64_t first = 1; first <= operations; ++first) {
    SCOPED_TRACE("operation " + std::to_string(first));
    const auto store = open();
    fail(first);
    const LoadedParameters loaded = store->load();
    operations = plan.count;
    plan.set({});
    if (loaded.source != Source::nothing) {
      EXPECT_EQ(generation_of(loaded.table), loaded.source == Source::current ? 2 : 1);
    }
    EXPECT_EQ(loaded.problem == ParameterProblem::none, loaded.source == Source::current);
    EXPECT_EQ(generation_of(store->load().table), 2);
  }
  EXPECT_GE(operations, 4U);
}

TEST_P(FailingOperation, OfTheStartEndsTheServiceOrLeavesALoadableSet) {
  save(1);
  for (std::uint64_t first = 1; first <= 6; ++first) {
    SCOPED_TRACE("operation " + std::to_string(first));
    fail(first);
    std::unique_ptr<ParameterStore> store;
    try {
      store = open();
    } catch (const ConfigurationError&) {
      continue;
    }
    plan.set({});
    EXPECT_EQ(generation_of(store->load().table), 1);
    EXPECT_NO_THROW(store->save(table_of(1))) << "locked by now";
  }
}

INSTANTIATE_TEST_SUITE_P(Parameters, FailingOperation, testing::Bool(), [](const auto& mode) {
  return mode.param ? "for_ever" : "once";
});

// ---- killed at every step --------------------------------------------------------------------

/// Saves one generation after the other, reports each save, and is killed before its file operation
/// number `last`.
[[noreturn]] void save_until_killed(const fs::path& directory, std::uint64_t last, int pipe_end) {
  FilePlan plan;
  plan.set([last](std::uint64_t number) {
    if (number == last) std::raise(SIGKILL);
  });
  ParameterStore store(directory, kBenchOfStore, std::make_unique<FailingFiles>(plan));
  std::int64_t generation = generation_of(store.load().table).value_or(0);
  for (;;) {
    ++generation;
    store.save(table_of(generation));
    if (write(pipe_end, &generation, sizeof(generation)) != sizeof(generation)) _exit(1);
  }
}

TEST_F(StateDirectory, SurvivesAServiceThatIsKilledAtAnyStepOfASave) {
  const auto kills = number_of<std::uint64_t>({.usual = 100, .full = 100, .nightly = 1'000});
  std::int64_t saved = 0;
  std::int64_t found = 0;
  for (std::uint64_t round = 0; round < kills; ++round) {
    std::array<int, 2> ends{};
    ASSERT_EQ(pipe(ends.data()), 0);
    const pid_t child = fork();
    if (child == 0) {
      close(ends[0]);
      save_until_killed(directory.path(), round % 100 + 1, ends[1]);  // about three saves
    }
    close(ends[1]);
    std::int64_t generation = 0;
    while (read(ends[0], &generation, sizeof(generation)) == sizeof(generation)) saved = generation;
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << "round " << round;
    const LoadedParameters loaded = load();
    ASSERT_EQ(loaded.problem, ParameterProblem::none) << "round " << round;
    const std::int64_t highest = std::max(saved, found) + 1;
    found = generation_of(loaded.table).value_or(0);
    ASSERT_GE(found, saved) << "round " << round;
    ASSERT_LE(found, highest) << "round " << round;
  }
  EXPECT_GT(saved, static_cast<std::int64_t>(kills) / 2) << "many of them saved something";
}

// ---- values of the axes -------------------------------------------------------------------------

service::Configuration three_axes() {
  service::Configuration configuration;
  configuration.axes = service::default_axes(3);
  return configuration;
}

TEST(StoredParameters, AreAppliedToTheirAxes) {
  auto configuration = three_axes();
  const LoadedParameters loaded{
      .table = {{1, {{kStoredVelocity, 5}}}, {3, {{kStoredVelocity, 6}}}, {9, {}}},
      .source = Source::current};
  const auto news = apply(loaded, configuration);
  ASSERT_EQ(news.size(), 1U);
  EXPECT_EQ(news[0].code, ParameterCode::kLoaded);
  EXPECT_EQ(news[0].detail, service::EventDetail{service::Count{2}})
      << "axis 9 is not on this bench";
  EXPECT_EQ(configuration.axes[0].configuration.stored.at(0).value, 5);
  EXPECT_TRUE(configuration.axes[1].configuration.stored.empty());
  EXPECT_EQ(configuration.axes[2].configuration.stored.at(0).value, 6);
  EXPECT_FALSE(configuration.axes[0].configuration.memory_error);
}

TEST(StoredParameters, AreAllDiscardedWhenOneIsNotUsable) {
  for (const InitialValue& bad :
       {InitialValue{{0x7000, 0}, 1}, InitialValue{{0x607A, 0}, 1},
        InitialValue{kStoredVelocity, -1}, InitialValue{{0x60F2, 0}, 3}}) {
    auto configuration = three_axes();
    const LoadedParameters loaded{
        .table = {{1, {{kStoredVelocity, 5}}}, {2, {{kLowerLimit, 6}, bad}}},
        .source = Source::current};
    const auto news = apply(loaded, configuration);
    ASSERT_EQ(news.size(), 2U);
    EXPECT_EQ(news[0].code, ParameterCode::kDefaults);
    EXPECT_EQ(news[0].axis, 2U);
    EXPECT_FALSE(configuration.axes[0].configuration.memory_error);
    EXPECT_TRUE(configuration.axes[1].configuration.memory_error);
    EXPECT_TRUE(configuration.axes[1].configuration.stored.empty());
    EXPECT_EQ(news[1].detail, service::EventDetail{service::Count{1}}) << "axis 1 has its values";
  }
}

TEST(StoredParameters, InADamagedFileCauseAFaultOnEveryAxis) {
  auto configuration = three_axes();
  const LoadedParameters loaded{.table = {{1, {{kStoredVelocity, 5}}}},
                                .source = Source::previous,
                                .problem = ParameterProblem::damaged};
  const auto news = apply(loaded, configuration);
  EXPECT_EQ(news.at(0).code, ParameterCode::kPrevious);
  EXPECT_EQ(std::get<service::StoredProblem>(news[0].detail).text(), "damaged");
  for (const auto& axis : configuration.axes) EXPECT_TRUE(axis.configuration.memory_error);
  EXPECT_EQ(configuration.axes[0].configuration.stored.at(0).value, 5);
  auto bare = three_axes();
  const auto nothing =
      apply({.table = {}, .problem = ParameterProblem::unreadable, .number = EACCES}, bare);
  ASSERT_EQ(nothing.size(), 1U);
  EXPECT_EQ(nothing[0].code, ParameterCode::kDefaults);
  EXPECT_EQ(std::get<service::StoredProblem>(nothing[0].detail).text(),
            "cannot be read: Permission denied");
  EXPECT_TRUE(bare.axes[2].configuration.memory_error);
}

std::string refusal_of_directory(const fs::path& directory) {
  try {
    const ParameterStore store(directory, kBenchOfStore);
  } catch (const ConfigurationError& error) {
    return error.what();
  }
  return "accepted";
}

fs::perms rights_of(const fs::path& file) {
  return fs::status(file).permissions();
}

TEST(StateDirectoryRights, AndItsFilesAreForTheirOwnerAlone) {
  const TemporaryDirectory parent;
  const fs::path made = parent.path() / "made";
  ParameterStore store(made, kBenchOfStore);
  store.save(table_of(1));
  EXPECT_EQ(rights_of(made), fs::perms::owner_all);
  for (const auto& entry : fs::directory_iterator(made)) {
    EXPECT_EQ(rights_of(entry.path()), fs::perms::owner_read | fs::perms::owner_write)
        << entry.path();
  }
}

TEST(StateDirectoryRights, ThatWasOpenToOthersIsNarrowedWithItsLock) {
  const TemporaryDirectory directory;
  const fs::path lock = directory.path() / "bench-7.lock";
  write_text(lock, "");
  fs::permissions(directory.path(), fs::perms{0755});
  fs::permissions(lock, fs::perms{0644});
  EXPECT_EQ(refusal_of_directory(directory.path()), "accepted");
  EXPECT_EQ(rights_of(directory.path()), fs::perms::owner_all);
  EXPECT_EQ(rights_of(lock), fs::perms::owner_read | fs::perms::owner_write);
}

TEST(StateDirectoryRights, AreRefusedWhereEverybodyMayWriteAndStayAsTheyAre) {
  const TemporaryDirectory directory;
  fs::permissions(directory.path(), fs::perms{01777});  // such as /tmp
  EXPECT_THAT(refusal_of_directory(directory.path()),
              testing::HasSubstr("everybody may write to it"));
  EXPECT_EQ(rights_of(directory.path()), fs::perms{01777});
}

TEST(StateDirectoryRights, MayBeReachedThroughALinkOfTheSameUserAndItsFilesMayNot) {
  const TemporaryDirectory parent;
  const fs::path real = parent.path() / "real";
  const fs::path link = parent.path() / "link";
  fs::create_directory(real);
  fs::create_directory_symlink(real, link);
  EXPECT_EQ(refusal_of_directory(link), "accepted");
  const fs::path elsewhere = parent.path() / "elsewhere";
  fs::remove(real / "bench-7.lock");
  fs::create_symlink(elsewhere, real / "bench-7.lock");
  EXPECT_EQ(refusal_of_directory(real), "state directory " + real.string() +
                                            ": bench-7.lock is a symbolic link, which is not "
                                            "followed");
  EXPECT_FALSE(fs::exists(elsewhere)) << "nothing was made behind the link";
  fs::remove(real / "bench-7.lock");
  write_text(elsewhere, encode(table_of(1)));
  fs::create_symlink(elsewhere, real / "bench-7.parameters");
  ParameterStore store(real, kBenchOfStore);
  EXPECT_EQ(store.load().problem, ParameterProblem::unreadable);
}

constexpr uid_t kStranger = 65'534;

/// Needs a second user, and only root can act as one.
class StateDirectoryAndAStranger : public testing::Test {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "only root can act as a second user";
    fs::permissions(parent_.path(), fs::perms{01777});
  }

  TemporaryDirectory parent_;
};

TEST_F(StateDirectoryAndAStranger, WhoCannotHoldItsLock) {
  const fs::path directory = parent_.path() / "state";
  fs::create_directory(directory);
  fs::permissions(directory, fs::perms{0755});  // as earlier versions created it
  { const ParameterStore store(directory, kBenchOfStore); }
  const std::string flock = "setpriv --reuid=65534 --clear-groups flock --nonblock " +
                            (directory / "bench-7.lock").string() + " true 2>/dev/null";
  EXPECT_NE(std::system(flock.c_str()), 0);  // NOLINT(*-mt-unsafe, cert-env33-c)
  EXPECT_EQ(refusal_of_directory(directory), "accepted");
}

TEST_F(StateDirectoryAndAStranger, WhoseDirectoryOrLinkIsRefused) {
  const fs::path directory = parent_.path() / "state";
  fs::create_directory(directory);
  ASSERT_EQ(chown(directory.c_str(), kStranger, kStranger), 0);
  EXPECT_EQ(refusal_of_directory(directory),
            "state directory " + directory.string() +
                ": state belongs to another user, or everybody may write to it; use a directory of "
                "the user that runs vdrived");
  const fs::path own = parent_.path() / "own";
  fs::create_directory(own);
  const fs::path link = parent_.path() / "link";
  fs::create_directory_symlink(own, link);
  ASSERT_EQ(lchown(link.c_str(), kStranger, kStranger), 0);
  EXPECT_EQ(refusal_of_directory(link),
            "state directory " + link.string() +
                ": is a symbolic link of another user, which is not followed");
}

TEST(StateDirectoryName, ComesFromTheCommandLineOrFromSystemd) {
  const TemporaryDirectory first;
  const TemporaryDirectory second;
  unsetenv("STATE_DIRECTORY");
  EXPECT_EQ(service::open_parameter_store(std::nullopt, 1), nullptr);
  setenv("STATE_DIRECTORY", "", 1);
  EXPECT_EQ(service::open_parameter_store(std::nullopt, 1), nullptr);
  setenv("STATE_DIRECTORY", (first.path().string() + ":/nowhere/at/all").c_str(), 1);
  EXPECT_NE(service::open_parameter_store(std::nullopt, 1), nullptr);
  EXPECT_TRUE(fs::exists(first.path() / "bench-1.lock"));
  EXPECT_NE(service::open_parameter_store(second.path().string(), 1), nullptr);
  EXPECT_TRUE(fs::exists(second.path() / "bench-1.lock"));
  unsetenv("STATE_DIRECTORY");
  EXPECT_THROW(static_cast<void>(service::open_parameter_store("", 1)), ConfigurationError);
}

}  // namespace
}  // namespace vdrive::test
