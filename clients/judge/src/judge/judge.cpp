// SPDX-License-Identifier: Apache-2.0
#include "judge/judge.hpp"

#include "judge/axis_track.hpp"
#include "judge/findings.hpp"
#include "judge/handshake_rules.hpp"
#include "judge/mode_rules.hpp"
#include "judge/motion_rules.hpp"
#include "judge/network_rules.hpp"
#include "judge/power_rules.hpp"
#include "judge/supervision_rules.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <variant>

namespace vdrive::judge {
namespace {

/// The track of one axis, and the state of each group of rules for it.
class AxisJudge {
 public:
  AxisJudge(std::uint32_t axis, const SourceFacts& facts, Findings& findings)
      : axis_(axis),
        has_time_(facts.has_time),
        shows_sessions_(facts.shows_sessions),
        findings_(findings) {
    track_.facts = (facts.has_time ? Fact::kTime : 0U) | (facts.shows_reads ? Fact::kReads : 0U) |
                   (facts.speed_is_per_second ? Fact::kSpeedUnit : 0U);
  }

  void take(const Record& record) {
    place_ = {.time = record.time, .tick = record.tick, .line = record.line};
    std::visit(
        [this](const auto& what) {
          apply(what);
        },
        record.what);
  }

  void end(bool is_over) {
    if (is_over) SupervisionRules::end(context());
    history_.close();
  }

  /// @return the facts that the source has shown about this axis.
  [[nodiscard]] std::uint32_t facts() const noexcept {
    const std::uint32_t sessions = shows_sessions_ ? 0U : Fact::kSessions;
    return track_.facts & ~sessions;
  }

 private:
  [[nodiscard]] Context context() {
    return {.track = track_,
            .findings = findings_,
            .history = history_,
            .axis = axis_,
            .place = place_,
            .has_time = has_time_};
  }

  void put_sample(std::optional<std::int32_t> position, std::optional<std::int32_t> demand) {
    history_.put(Sample{.time = place_.time,
                        .position = position,
                        .demand = demand,
                        .target = track_.target,
                        .statusword = track_.statusword});
  }

  void apply(const Write& write) {
    const Context now = context();
    network_.take(write, now);
    handshake_.take(write, now);
    power_.take(write, now);
    mode_.take(write, now);
    motion_.take(write, now);
    supervision_.take(write, now);
    const bool is_repeated = write.channel == Channel::pdo && is_as_before(write);
    track_.apply(write, place_.time);
    if (write.object == objects::kTarget) {
      put_sample({}, {});
    }
    if (!is_repeated) put_line(&write, {}, 0);
  }

  void apply(const Shown& shown) {
    const std::uint16_t word = track_.statusword;
    const auto mode = track_.mode_shown;
    const bool had_status = track_.has_status;
    track_.apply(shown, place_.time);
    const bool has_word = shown.has(ShownMember::kStatusword);
    const bool is_new_word = has_word && (!had_status || word != track_.statusword);
    if (is_new_word || mode != track_.mode_shown) {
      put_line(nullptr, is_new_word ? "6041h" : "6061h", 0);
    }
    if (shown.has(ShownMember::kPosition)) {
      put_sample(track_.position, track_.demand);
    }
    const Context now = context();
    handshake_.take(shown, now);
    mode_.take(shown, now);
    motion_.take(shown, now);
    power_.take(shown, now);
    supervision_.take(shown, now);
  }

  void apply(const Reading& reading) {
    track_.apply(reading);
    const bool is_cause =
        reading.object == objects::kErrorCode || reading.object == objects::kErrorField;
    if (is_cause && reading.is_of_the_master && reading.code == 0) power_.note_cause();
  }

  void apply(const Network& network) {
    if (network.is_command) SupervisionRules::take(network, context());
    const bool is_new = track_.apply(network, place_.time);
    network_.take(network);
    if (network.state == NodeState::initialising) {
      forget();
      track_.restart();
    }
    if (is_new) put_line(nullptr, name_of(network), 0);
  }

  void apply(const Sync& sync) {
    track_.facts |= Fact::kSync;
    network_.take(sync, context());
  }

  void apply(const Emergency& emergency) {
    if (emergency.code != 0) power_.note_cause();
    put_line(nullptr, "emergency", emergency.code);
  }

  void apply(const ReceivePdo& pdo) {
    if (pdo.type) track_.facts |= Fact::kTransmissionType;
    network_.take(pdo, context());
  }

  void apply(const KeepAlive& sign) {
    track_.facts |= Fact::kKeepAlive;
    supervision_.take(sign, context());
  }

  void apply(const Gap& gap) {
    forget();
    put_line(nullptr, gap.cause, 0);
  }

  void forget() {
    track_.forget();
    handshake_.forget();
    power_.forget();
    mode_.forget();
    motion_.forget();
    network_.forget();
    supervision_.forget();
  }

  [[nodiscard]] bool is_as_before(const Write& write) const {
    if (write.object == objects::kControlword) {
      return track_.has_controlword && write.value == track_.controlword;
    }
    if (write.object == objects::kTarget) return track_.target == write.value;
    if (write.object == objects::kMode) return track_.mode_wanted == write.value;
    return track_.values.find(write.object) == write.value;
  }

  static std::string_view name_of(const Network& network) {
    switch (network.state) {
      case NodeState::initialising:
        return network.is_command ? "NMT reset" : "boot-up";
      case NodeState::pre_operational:
        return network.is_command ? "NMT enter pre-operational" : "node is Pre-operational";
      case NodeState::operational:
        return network.is_command ? "NMT start" : "node is Operational";
      case NodeState::stopped:
        return network.is_command ? "NMT stop" : "node is Stopped";
    }
    return {};
  }

  void put_line(const Write* write, std::string_view event, std::uint16_t code) {
    Line line;
    line.place = place_;
    if (write != nullptr) line.write = *write;
    line.event = event;
    line.event_code = code;
    if (track_.has_controlword) line.controlword = track_.controlword;
    if (track_.has_status) line.statusword = track_.statusword;
    line.mode = track_.mode_in_force();
    line.target = track_.target;
    line.actual = track_.position;
    line.waiting = track_.waiting();
    history_.put(line);
  }

  std::uint32_t axis_;
  bool has_time_;
  bool shows_sessions_;
  Findings& findings_;
  AxisTrack track_;
  History history_;
  Place place_;
  HandshakeRules handshake_;
  PowerRules power_;
  ModeRules mode_;
  MotionRules motion_;
  NetworkRules network_;
  SupervisionRules supervision_;
};

}  // namespace

struct Judge::State {
  static constexpr std::uint32_t kIndexed = 1U << 16U;

  explicit State(const SourceFacts& source) : facts(source) {}

  AxisJudge& axis(std::uint32_t number) {
    if (number < by_number.size() && by_number[number] != nullptr) return *by_number[number];
    AxisJudge& made = axes.try_emplace(number, number, facts, findings).first->second;
    if (number < kIndexed) {
      if (by_number.size() <= number) by_number.resize(number + 1);
      by_number[number] = &made;
    }
    return made;
  }

  [[nodiscard]] std::vector<Unjudged> unjudged() const;

  SourceFacts facts;
  Findings findings;
  std::map<std::uint32_t, AxisJudge> axes;
  std::vector<AxisJudge*> by_number;  ///< into `axes`, for fast access by each record
  std::uint64_t records = 0;
  Time first{};
  Time last{};
};

/// A rule that lacks several facts is listed under the first one.
std::vector<Unjudged> Judge::State::unjudged() const {
  std::map<std::pair<std::uint32_t, std::vector<std::uint32_t>>, std::vector<Rule>> by_axes;
  for (const RuleRow& row : rules()) {
    std::map<std::uint32_t, std::vector<std::uint32_t>> missing;
    for (const auto& [number, axis] : axes) {
      const std::uint32_t lacking = row.needs & ~axis.facts();
      if (lacking != 0) missing[lacking & (~lacking + 1U)].push_back(number);
    }
    for (auto& [fact, numbers] : missing) by_axes[{fact, std::move(numbers)}].push_back(row.rule);
  }
  std::vector<Unjudged> all;
  all.reserve(by_axes.size());
  for (auto& [key, of_rules] : by_axes) {
    all.push_back({.fact = key.first, .rules = std::move(of_rules), .axes = key.second});
  }
  return all;
}

bool fails(const Verdict& verdict, std::optional<Severity> fail_on) {
  return fail_on && std::ranges::any_of(verdict.findings, [&](const Finding& finding) {
           return row_of(finding.rule).severity <= *fail_on;
         });
}

Judge::Judge(const SourceFacts& facts) : state_(std::make_unique<State>(facts)) {}

Judge::~Judge() = default;
Judge::Judge(Judge&&) noexcept = default;
Judge& Judge::operator=(Judge&&) noexcept = default;

void Judge::take(const Record& record) {
  State& state = *state_;
  if (state.records++ == 0) state.first = record.time;
  state.last = std::max(state.last, record.time);
  state.axis(record.axis).take(record);
}

Verdict Judge::end(bool is_over) {
  for (auto& [number, axis] : state_->axes) axis.end(is_over);
  Verdict last = verdict();
  state_->findings.clear();
  return last;
}

Verdict Judge::verdict() const {
  const State& state = *state_;
  Verdict verdict;
  verdict.findings = state.findings.all();
  verdict.unjudged = state.unjudged();
  verdict.axes.reserve(state.axes.size());
  for (const auto& [number, axis] : state.axes) verdict.axes.push_back(number);
  verdict.records = state.records;
  verdict.first = state.first;
  verdict.last = state.last;
  return verdict;
}

}  // namespace vdrive::judge
