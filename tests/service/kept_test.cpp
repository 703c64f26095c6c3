// SPDX-License-Identifier: Apache-2.0
// Every 1.x version reads the files that version 1.0 wrote (docs/reference/compatibility.md).
#include "configuration/configuration_file.hpp"
#include "journal/journal_file.hpp"
#include "journal/replay.hpp"
#include "store/parameter_file.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace vdrive::test {
namespace {

const std::filesystem::path kKept = VDRIVE_SOURCE_DIR "/tests/data/kept/1.0";

/// @return the value that an axis of the configuration writes to an object at power-up, if any.
std::optional<std::int64_t> value_in(const std::vector<InitialValue>& values,
                                     ObjectAddress object) {
  const auto found =
      std::find_if(values.begin(), values.end(), [object](const InitialValue& value) {
        return value.address == object;
      });
  return found == values.end() ? std::nullopt : std::optional(found->value);
}

TEST(FilesOf1_0, AConfigurationIsReadToTheSameBench) {
  const service::Configuration bench = service::load_configuration(kKept / "bench.yaml");
  EXPECT_EQ(bench.bench, 7U);
  EXPECT_EQ(bench.name, "kept");
  EXPECT_EQ(bench.clock, service::ClockMode::lockstep);
  EXPECT_EQ(bench.watchdog, std::nullopt);
  ASSERT_EQ(bench.axes.size(), 2U);
  const service::NamedAxis& lift = bench.axes[0];
  EXPECT_EQ(lift.name, "lift");
  // A turn of the screw is 4096 UU, 5 mm.
  EXPECT_EQ(lift.unit, (Unit{.kind = UnitKind::linear, .name = "mm", .size = 819.2}));
  EXPECT_EQ(value_in(lift.configuration.parameters, {0x607D, 1}), -8'192);
  EXPECT_EQ(value_in(lift.configuration.parameters, {0x607D, 2}), 245'760);
  EXPECT_EQ(value_in(lift.configuration.parameters, {0x6081, 0}), 9'830);  // 12 mm/s
  const service::NamedAxis& table = bench.axes[1];
  EXPECT_EQ(table.unit, Unit{});
  EXPECT_EQ(table.configuration.model.load_inertia, 3.0e-4);
  EXPECT_EQ(value_in(table.configuration.parameters, {0x6083, 0}), 6'000);
  EXPECT_EQ(value_in(table.configuration.parameters, {0x6084, 0}), 6'000);
}

TEST(FilesOf1_0, StoredParametersAreReadWithTheirValues) {
  std::ifstream file(kKept / "bench-7.parameters", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const service::ParameterTable table = service::decode(std::as_bytes(std::span(bytes)));
  ASSERT_EQ(table.size(), 1U);
  const std::vector<InitialValue>& values = table.at(2);
  EXPECT_EQ(value_in(values, {0x6081, 0}), 1'234);
  EXPECT_EQ(value_in(values, {0x6083, 0}), 6'000);
  EXPECT_EQ(value_in(values, {0x605A, 0}), 2);
}

TEST(FilesOf1_0, AJournalHasItsConfigurationChangesAndTicks) {
  std::ifstream file(kKept / "run.journal", std::ios::binary);
  service::JournalReader reader(file);
  EXPECT_EQ(reader.start().rows, 2U);
  const service::Configuration bench =
      service::parse_configuration(reader.start().configuration, "the kept journal");
  EXPECT_EQ(bench.axes.at(0).name, "lift");
  std::uint64_t ticks = 0;
  std::vector<service::JournalChange> stored;
  std::optional<service::JournalEnd> end;
  while (const auto record = reader.next()) {
    if (std::holds_alternative<service::JournalTick>(*record)) ++ticks;
    if (const auto* const change = std::get_if<service::JournalChange>(&*record)) {
      if (change->kind == service::JournalChange::Kind::stored) stored.push_back(*change);
    }
    if (const auto* const last = std::get_if<service::JournalEnd>(&*record)) end = *last;
  }
  ASSERT_TRUE(end);
  EXPECT_GT(ticks, 100U);
  EXPECT_EQ(end->ticks, ticks);
  EXPECT_EQ(end->lost, 0U);
  const auto speed = std::find_if(stored.begin(), stored.end(), [](const auto& change) {
    return change.address == ObjectAddress{0x6081, 0};
  });
  ASSERT_NE(speed, stored.end());
  EXPECT_EQ(speed->axis, 1);
  EXPECT_EQ(speed->value, 1'234);
}

// Another minor version may lay the state out differently; the refusal then names the version that
// wrote the journal.
TEST(FilesOf1_0, AJournalIsReplayedToTheSameBitsOrRefusedWithItsVersion) {
  std::ifstream file(kKept / "run.journal", std::ios::binary);
  const service::JournalStart start = service::JournalReader(file).start();
  if (start.layout == AxisBank::snapshot_layout()) {
    const service::ReplayResult result = service::replay(kKept / "run.journal");
    EXPECT_TRUE(result.agrees && result.is_complete) << result.text;
    return;
  }
  ASSERT_FALSE(std::string(VDRIVE_VERSION).starts_with("1.0."))
      << "within 1.0 the layout of the state stays";
  try {
    (void)service::replay(kKept / "run.journal");
    FAIL() << "it was replayed with another layout";
  } catch (const service::JournalError& error) {
    EXPECT_NE(std::string(error.what()).find(start.version), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace vdrive::test
