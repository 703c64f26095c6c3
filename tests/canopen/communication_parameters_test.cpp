// SPDX-License-Identifier: Apache-2.0
// Saving by 1010h:01, restoring at a reset, and the order of the restoring writes.
#include "node/communication_parameters.hpp"

#include "node/node_object.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;
using testing::SizeIs;

using Values = CommunicationParameters::Values;

/// Records the writes of restore().
class WrittenParameters {
 public:
  /// @param refused the object whose write is answered with an abort
  explicit WrittenParameters(const CommunicationParameters& parameters,
                             std::optional<ObjectAddress> refused = std::nullopt) {
    parameters.restore([&](ObjectAddress object, std::uint32_t value) {
      order.emplace_back(object, value);
      return object == refused ? AbortCode::value_range_exceeded : AbortCode::none;
    });
  }

  std::vector<std::pair<ObjectAddress, std::uint32_t>> order;
};

TEST(CommunicationParameters, AreTheWritableObjectsOfTheNodeItself) {
  EXPECT_TRUE(CommunicationParameters::has({0x1014, 0}));
  EXPECT_TRUE(CommunicationParameters::has({0x1016, 4}));
  EXPECT_TRUE(CommunicationParameters::has({0x1029, 1}));
  EXPECT_TRUE(CommunicationParameters::has({0x1A03, 8}));
  EXPECT_FALSE(CommunicationParameters::has({0x1016, 0})) << "constant";
  EXPECT_FALSE(CommunicationParameters::has({0x1008, 0})) << "constant";
  EXPECT_FALSE(CommunicationParameters::has({0x1200, 1})) << "constant";
  EXPECT_FALSE(CommunicationParameters::has({0x6067, 0})) << "of the drive";
  EXPECT_FALSE(CommunicationParameters::has({0x1010, 1})) << "of the drive";
  EXPECT_FALSE(CommunicationParameters::has({0x100C, 0})) << "no object";
}

TEST(CommunicationParameters, StoreWhatDiffersFromItsDefault) {
  const CommunicationParameters parameters(5, {});
  const Values stored = parameters.to_store([](ObjectAddress object) {
    if (object == ObjectAddress{0x1017, 0}) return 500U;
    const NodeObject* const found = find_node_object(object);
    return found == nullptr ? 0U : static_cast<std::uint32_t>(default_of(*found, 5));
  });
  EXPECT_THAT(stored, ElementsAre(Pair(ObjectAddress{0x1017, 0}, 500U)));
}

TEST(CommunicationParameters, AskForEachParameterOnceWhenTheyAreStored) {
  const CommunicationParameters parameters(5, {});
  Values asked;
  const Values values = parameters.to_store([&asked](ObjectAddress object) {
    ++asked[object];
    return 0U;
  });
  EXPECT_THAT(parameters.stored(), IsEmpty()) << "not yet";
  EXPECT_THAT(values, Contains(Pair(ObjectAddress{0x1014, 0}, 0U))) << "whose default is 085h";
  for (const NodeObject& object : node_objects()) {
    const bool is_parameter = CommunicationParameters::has(object.address);
    EXPECT_EQ(asked.count(object.address), is_parameter ? 1U : 0U);
    if (is_parameter) {
      EXPECT_EQ(asked[object.address], 1U);
    }
  }
}

TEST(CommunicationParameters, ForgetWhatWasStored) {
  CommunicationParameters parameters(5, {{{0x1017, 0}, 500}});
  parameters.set_stored({});
  EXPECT_THAT(parameters.stored(), IsEmpty());
  EXPECT_THAT(WrittenParameters(parameters).order, IsEmpty());
}

TEST(CommunicationParameters, LeaveOutWhatIsNoParameterAndWhatIsTheDefault) {
  const Values stored{{{0x1017, 0}, 500}, {{0x1008, 0}, 1},     {{0x6067, 0}, 7},
                      {{0x2345, 6}, 7},   {{0x1014, 0}, 0x085}, {{0x1015, 0}, 0}};
  EXPECT_THAT(CommunicationParameters(5, stored).stored(),
              ElementsAre(Pair(ObjectAddress{0x1017, 0}, 500U)))
      << "0085h is the default of 1014h in node 5";
}

TEST(CommunicationParameters, RestoreNothingWhereNothingIsStored) {
  EXPECT_THAT(WrittenParameters(CommunicationParameters(5, {})).order, IsEmpty());
}

TEST(CommunicationParameters, SwitchTheEmergencyOffWhileItsCobIdChanges) {
  const CommunicationParameters parameters(5, {{{0x1014, 0}, 0xA5}});
  EXPECT_THAT(WrittenParameters(parameters).order,
              ElementsAre(Pair(ObjectAddress{0x1014, 0}, 0x8000'0085U),
                          Pair(ObjectAddress{0x1014, 0}, 0xA5U)));
}

TEST(CommunicationParameters, SwitchTheEmergencyOnAgainWhenTheStoredCobIdIsRefused) {
  const CommunicationParameters parameters(5, {{{0x1014, 0}, 0x581}});
  EXPECT_THAT(
      WrittenParameters(parameters, ObjectAddress{0x1014, 0}).order,
      ElementsAre(Pair(ObjectAddress{0x1014, 0}, 0x8000'0085U),
                  Pair(ObjectAddress{0x1014, 0}, 0x581U), Pair(ObjectAddress{0x1014, 0}, 0x85U)));
}

// 1019h is refused unless 1006h is 0.
TEST(CommunicationParameters, RestoreTheOverflowOfTheSyncCounterFirst) {
  const CommunicationParameters parameters(
      5, {{{0x1005, 0}, 0x90}, {{0x1006, 0}, 10'000}, {{0x1019, 0}, 10}, {{0x1029, 1}, 1}});
  EXPECT_THAT(
      WrittenParameters(parameters).order,
      ElementsAre(Pair(ObjectAddress{0x1019, 0}, 10U), Pair(ObjectAddress{0x1005, 0}, 0x90U),
                  Pair(ObjectAddress{0x1006, 0}, 10'000U), Pair(ObjectAddress{0x1029, 1}, 1U)));
}

// The order of CiA 301, 7.5.2.36: not valid, count 0, entries, count, parameters, valid.
TEST(CommunicationParameters, RestoreAPdoAsAMasterRemapsIt) {
  const CommunicationParameters parameters(
      5,
      {{{0x1800, 2}, 1}, {{0x1A00, 0}, 2}, {{0x1A00, 1}, 0x6041'0010}, {{0x1A00, 2}, 0x6064'0020}});
  std::vector<ObjectAddress> objects;
  const auto order = WrittenParameters(parameters).order;
  for (const auto& write : order) {
    if (objects.empty() || objects.back() != write.first) objects.push_back(write.first);
  }
  // 1A00h:01 has its default value, so it is not stored.
  EXPECT_THAT(objects, ElementsAre(ObjectAddress{0x1800, 1}, ObjectAddress{0x1A00, 0},
                                   ObjectAddress{0x1A00, 2}, ObjectAddress{0x1A00, 0},
                                   ObjectAddress{0x1800, 2}, ObjectAddress{0x1800, 1}));
  EXPECT_EQ(order.front().second, 0x8000'0185U) << "not valid";
  EXPECT_EQ(order.back().second, 0x185U) << "valid again";
  EXPECT_THAT(order, testing::Contains(Pair(ObjectAddress{0x1A00, 0}, 0U)));
  EXPECT_THAT(order, testing::Contains(Pair(ObjectAddress{0x1A00, 0}, 2U)));
}

TEST(CommunicationParameters, KeepTheCountOfAPdoWhoseEntriesAreStoredWithoutIt) {
  const CommunicationParameters parameters(5, {{{0x1A02, 2}, 0x606C'0020}});
  const auto order = WrittenParameters(parameters).order;
  EXPECT_THAT(order, testing::Contains(Pair(ObjectAddress{0x1A02, 0}, 2U))) << "the default";
}

TEST(CommunicationParameters, LeaveTheMappingOfAPdoAloneThatHasOnlyAnotherCobId) {
  const CommunicationParameters parameters(5, {{{0x1403, 1}, 0x8000'0505}});
  const auto order = WrittenParameters(parameters).order;
  EXPECT_THAT(order, testing::Not(IsEmpty()));
  for (const auto& write : order) {
    EXPECT_EQ(write, (std::pair{ObjectAddress{0x1403, 1}, 0x8000'0505U}));
  }
}

TEST(CommunicationParameters, RestoreTheOthersWhenOneIsRefused) {
  const CommunicationParameters parameters(5, {{{0x1015, 0}, 100}, {{0x1017, 0}, 500}});
  EXPECT_THAT(WrittenParameters(parameters, ObjectAddress{0x1015, 0}).order, SizeIs(2));
}

TEST(CommunicationParameters, HaveTheirDefaultsUntilTheyAreSetAndAfterAReset) {
  CommunicationParameters parameters(5, {});
  EXPECT_EQ(parameters.value({0x1029, 1}), 0U);
  parameters.set_value({0x1029, 1}, 2);
  EXPECT_EQ(parameters.value({0x1029, 1}), 2U);
  parameters.reset();
  EXPECT_EQ(parameters.value({0x1029, 1}), 0U);
}

}  // namespace
}  // namespace vdrive::canopen
