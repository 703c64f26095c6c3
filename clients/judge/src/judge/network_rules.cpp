// SPDX-License-Identifier: Apache-2.0
#include "judge/network_rules.hpp"

#include "judge/words.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;

constexpr std::uint8_t kLastSynchronousType = 240;
constexpr std::uint8_t kFirstEventDrivenType = 254;
constexpr Time kTwoSessions = 1s;
constexpr Time kStillInUse = 1s;   ///< an older PDO may have been from another master
constexpr Time kUnderWay = 200ms;  ///< for messages sent before the master saw the new state
constexpr std::uint32_t kWithoutSync = 3;
constexpr Time kNoSync = 1s;
constexpr std::uint32_t kCyclesOfAStream = 50;
constexpr std::uint64_t kSyncsToJudge = 100;
constexpr double kPeriodTolerance = 0.1;
constexpr std::uint64_t kIrregularOf = 20;  ///< SYNCs, of which at most one may be irregular

/// Objects that command motion: if two writers write them, there are two masters.
bool is_command(ObjectAddress object) {
  return object == objects::kControlword || object == objects::kTarget ||
         object == objects::kMode || object == objects::kTargetVelocity ||
         object == objects::kTargetTorque;
}

std::string name_of(NodeState state) {
  if (state == NodeState::stopped) return "Stopped";
  return state == NodeState::pre_operational ? "Pre-operational" : "Initialising";
}

/// A pause does not count as an interval: the master has stopped its SYNC on purpose.
void put_distance(Distances& distances, Time distance) {
  constexpr int kPeriodsOfAPause = 20;
  const auto period = distances.period();
  if (!period || distance / kPeriodsOfAPause < *period) distances.put(distance);
}

}  // namespace

void NetworkRules::forget() {
  *this = {};
}

void NetworkRules::take(const Write& write, const Context& context) {
  if (!is_taken(write)) return;
  if (!is_command(write.object)) return;
  if (write.object != objects::kControlword && write.object != objects::kMode) has_target_ = true;
  if (write.channel == Channel::pdo || write.channel == Channel::sdo) {
    return take_shared(write, context);
  }
  if (write.writer == 0 || write.writer == writer_) return;
  const bool is_back =
      write.writer == writer_before_ && context.now() - writer_since_ < kTwoSessions;
  if (is_back) {
    context.report(Rule::writers_two_sessions, [&] {
      return "session " + session_text(write.writer) + " and session " + session_text(writer_) +
             " wrote alternately within " + duration_text(context.now() - writer_since_) +
             ", the last was " + object_name(write.object);
    });
  }
  writer_before_ = writer_;
  writer_ = write.writer;
  writer_since_ = context.now();
}

void NetworkRules::take(const Network& network) {
  if (network.state != NodeState::operational) shared_.clear();
}

/// A PDO that still carries the old value undoes an SDO write.
void NetworkRules::take_shared(const Write& write, const Context& context) {
  const auto known = shared_.find(write.object);
  if (write.channel == Channel::sdo) {
    if (known == shared_.end()) return;
    if (context.now() - known->second.pdo_time > kStillInUse) return;
    known->second.of_sdo = write.value;
    known->second.sdo_time = context.now();
    return;
  }
  if (known == shared_.end()) {
    shared_[write.object] = {.of_pdo = write.value, .of_sdo = {}, .pdo_time = context.now()};
    return;
  }
  Shared& shared = known->second;
  shared.pdo_time = context.now();
  const auto of_sdo = std::exchange(shared.of_sdo, std::nullopt);
  const bool is_old = write.value == std::exchange(shared.of_pdo, write.value);
  if (!of_sdo || *of_sdo == write.value || !is_old) return;
  context.report(Rule::writers_sdo_beside_pdo, [&] {
    return "RPDO " + std::to_string(write.writer) + " set " + object_name(write.object) +
           " back to " + std::to_string(write.value) + ", " +
           duration_text(context.now() - shared.sdo_time) + " after SDO had written " +
           std::to_string(*of_sdo);
  });
}

void NetworkRules::take(const ReceivePdo& pdo, const Context& context) {
  const auto& state = context.track.node_state;
  const auto& left = context.track.left_operational;
  const bool is_under_way = left && context.now() - *left < kUnderWay;
  if (state && *state != NodeState::operational && !is_under_way) {
    context.report(Rule::pdo_not_operational, [&] {
      return "RPDO " + std::to_string(pdo.number) + " came while the node was " + name_of(*state);
    });
  }
  Pdo& known = pdos_[pdo.number];
  known.type = pdo.type;
  ++known.since_sync;
  if (!pdo.type || *pdo.type > kLastSynchronousType) return;
  if (last_sync_ && context.now() - *last_sync_ < kNoSync) {
    known.without_sync = 0;
    if (known.since_sync != 2) return;
    return context.report(Rule::pdo_two_in_a_cycle, [&] {
      return "a second RPDO " + std::to_string(pdo.number) + " came " +
             duration_text(context.now() - *last_sync_) + " after SYNC, before the next one";
    });
  }
  wait_for_sync(pdo.number, known, context);
}

/// A synchronous PDO has arrived after a long time without SYNC.
void NetworkRules::wait_for_sync(std::uint16_t number, Pdo& pdo, const Context& context) {
  if (pdo.without_sync++ == 0) pdo.first_without_sync = context.now();
  const Time since = context.now() - pdo.first_without_sync;
  if (pdo.without_sync < kWithoutSync || since < kNoSync) return;
  pdo.without_sync = 0;
  context.report(Rule::sync_absent, [&] {
    return "RPDO " + std::to_string(number) + " has transmission type " +
           std::to_string(*pdo.type) + ", and there was no SYNC for " + duration_text(since);
  });
}

void NetworkRules::take(const Sync& /*sync*/, const Context& context) {
  const bool is_cyclic = context.track.is_enabled() && context.track.is_cyclic();
  for (auto& [number, pdo] : pdos_) end_cycle(number, pdo, context);
  if (is_cyclic && !is_cyclic_) {  // SYNC may have had another period before the stream
    syncs_.reset();
    targets_.reset();
    last_target_sync_.reset();
    has_target_ = false;
    is_period_judged_ = false;
  } else if (last_sync_) {
    put_distance(syncs_, context.now() - *last_sync_);
    if (std::exchange(has_target_, false)) {
      if (last_target_sync_) put_distance(targets_, *last_sync_ - *last_target_sync_);
      last_target_sync_ = last_sync_;
    }
  }
  is_cyclic_ = is_cyclic;
  last_sync_ = context.now();
  if (is_cyclic) judge_period(context);
}

void NetworkRules::end_cycle(std::uint16_t number, Pdo& pdo, const Context& context) {
  const AxisTrack& track = context.track;
  const bool is_one = pdo.since_sync == 1 && track.is_enabled() && track.is_cyclic();
  pdo.one_a_cycle = is_one ? pdo.one_a_cycle + 1 : 0;
  pdo.since_sync = 0;
  pdo.without_sync = 0;
  if (pdo.one_a_cycle != kCyclesOfAStream || !pdo.type || *pdo.type < kFirstEventDrivenType) return;
  context.report(Rule::pdo_event_driven_stream, [&pdo, number] {
    return "RPDO " + std::to_string(number) + " has transmission type " +
           std::to_string(*pdo.type) + " and came once in each of " +
           std::to_string(kCyclesOfAStream) + " cycles of SYNC";
  });
}

void NetworkRules::judge_period(const Context& context) {
  if (syncs_.count() >= kSyncsToJudge && syncs_.count() % kSyncsToJudge == 0 &&
      syncs_.irregular() * kIrregularOf > syncs_.count()) {
    context.report(Rule::sync_jitter, [&] {
      return "SYNC intervals: " + syncs_.text();
    });
  }
  const auto units = context.track.values.find(objects::kCyclePeriod);
  const auto period = targets_.period();
  if (!units || !period || is_period_judged_) return;
  is_period_judged_ = true;
  constexpr std::int64_t kMilliseconds = -3;
  constexpr std::int64_t kLowest = -128;  // 60C2h:02 is an INTEGER8; in a log it may be wrong
  constexpr std::int64_t kHighest = 63;
  const std::int64_t index = std::clamp(
      context.track.values.find(objects::kCycleIndex).value_or(kMilliseconds), kLowest, kHighest);
  const double wanted = static_cast<double>(*units) * std::pow(10.0, static_cast<double>(index));
  const double measured = std::chrono::duration<double>(*period).count();
  if (std::abs(measured - wanted) <= kPeriodTolerance * measured) return;
  context.report(Rule::sync_period, [&] {
    constexpr double kNanoseconds = 1.0e9;
    constexpr double kLongest = 1.0e9;  // [s]
    const bool is_duration = wanted >= 0 && wanted <= kLongest;
    return "a target arrives every " + duration_text(*period) + " with SYNC, but 60C2h is " +
           (is_duration ? duration_text(Time(static_cast<std::int64_t>(wanted * kNanoseconds)))
                        : "not a valid time");
  });
}

}  // namespace vdrive::judge
