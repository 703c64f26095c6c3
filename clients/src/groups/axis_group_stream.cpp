// SPDX-License-Identifier: Apache-2.0
// Cyclic streaming of positions, velocities and torques.
#include "base/drive_words.hpp"
#include "groups/group_state.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using namespace literals;

// Enough for a change of mode: it takes one tick at rest, but a moving axis brakes first.
constexpr std::chrono::seconds kModeChange{5};

// A set-point sent less than two ticks ahead cannot meet its tick.
constexpr std::uint64_t kShortestLead = 2;
// A bench refuses frames more than 10 s ahead, and keeps at most 1,024 from all sessions.
constexpr std::chrono::seconds kLongestLead{1};

const StreamedRow& streamed_row(Streamed what) {
  return kStreamedRows.at(static_cast<std::size_t>(what));
}

void put_set_point(msg::AxisCommand& command, const StreamedRow& row, std::int32_t value) {
  if (row.what == Streamed::positions) {
    command.members = msg::HAS_POSITION_USER_TARGET_VALUE;
    command.position_user_target_value = value;
  } else {
    add_object(command, vdrive::describe(row.object).address, value);
  }
}

std::uint64_t lead_of(const Stream& stream) {
  return std::max(kShortestLead,
                  ticks_of(std::min<std::chrono::nanoseconds>(stream.options.lead, kLongestLead),
                           stream.call.period()));
}

/// Releases drives that follow positions only with bits 4 to 6 of 6040h (5E20h:02). Each gets its
/// present position first, so that bit 12 shows the release.
/// @param released receives the places of these axes
Outcome release_positions(AxesCall& call, std::vector<std::size_t>& released) {
  const auto habits =
      call.read(std::array{kObjectRows["habit_stream_release_bits"_object].address});
  if (!habits) return habits.outcome();
  Round round;
  for (std::size_t place = 0; place < habits->size(); ++place) {
    if ((*habits)[place].front() == 0) continue;
    released.push_back(place);
    msg::AxisCommand command = call.command_to(place);
    command.members = msg::HAS_POSITION_USER_TARGET_VALUE;
    command.position_user_target_value = call.snapshots()[place].status.position_demand_value;
    add_word(command, kReleaseStream);
    round.entries.push_back({place, std::move(command)});
  }
  if (released.empty()) return {};
  const Answers answers = call.exchange({&round, 1}, Timing::at_once);
  if (!answers.outcome) return answers.outcome;
  return call.await_enabled("the release of its positions, bit 12", answers.tick,
                            [&](std::size_t place) {
                              return std::ranges::find(released, place) == released.end() ||
                                     call.snapshots()[place].shows(Statusword::kFollowsCommand);
                            });
}

}  // namespace

Round mode_round(const AxesCall& call, OperatingMode mode) {
  Round round = call.round_to(every_axis);
  for (Round::Entry& entry : round.entries) {
    entry.command.members = msg::HAS_OP_MODE_CMD;
    entry.command.op_mode_cmd = static_cast<std::int8_t>(mode);
  }
  round.flags = msg::FRAME_ALL_OR_NOTHING;
  return round;
}

Outcome AxisGroup::start_streaming(const StreamOptions& options) {
  AxesCall call = state_->call({});
  if (Outcome ready = call.begin_control(kModeChange); !ready) return ready;
  if (Outcome able = call.require(is_enabled, "streaming", "Operation enabled"); !able) return able;
  for (const AxisSnapshot& axis : call.snapshots()) {
    if (axis.status.velocity_demand_value != 0) {
      return not_in_this_state("axis " + to_string(axis.id) + " still moves");
    }
  }
  state_->drop_all();
  const StreamedRow& row = streamed_row(options.what);
  Round mode = mode_round(call, row.mode);
  for (Round::Entry& entry : mode.entries) {
    for (const ObjectValue& left_over : objects_before_stream()) {
      add_object(entry.command, left_over.object, left_over.value);
    }
  }
  const Answers answers = call.exchange({&mode, 1}, Timing::at_once);
  if (!answers.outcome) return state_->explained(answers.outcome);
  Outcome seen = call.await_enabled(std::string(to_string(row.mode)) + " mode", answers.tick,
                                    [&row](const AxisSnapshot& axis) {
                                      return axis.mode() == row.mode;
                                    });
  std::vector<std::size_t> released;
  if (seen && row.what == Streamed::positions) seen = release_positions(call, released);
  if (!seen) return state_->explained(std::move(seen));
  state_->stream = std::make_unique<Stream>(Stream{.row = row,
                                                   .options = options,
                                                   .call = std::move(call),
                                                   .in_flight = {},
                                                   .next_tick = 0,
                                                   .released = std::move(released)});
  return {};
}

Result<GroupStatus> AxisGroup::stream(const Eigen::VectorXd& set_points) {
  if (Outcome here = state_->core->discovery.check_process(); !here) return here;
  if (!state_->stream) return not_in_this_state("streaming was not started");
  state_->core->failure.rethrow();
  const StreamedRow& row = state_->stream->row;
  const auto whole = state_->set_points_of(set_points, row);
  if (!whole) return whole.outcome();
  AxesCall& call = state_->stream->call;
  Round round = call.round_to(every_axis);
  round.is_endless = true;
  for (Round::Entry& entry : round.entries) {
    put_set_point(entry.command, row, (*whole)[entry.place]);
  }
  Outcome sent = call.steps() ? state_->stream_stepping(round) : state_->stream_ahead(round);
  if (!sent) return state_->explained(call.stop_if_lost(std::move(sent)));
  if (Outcome sound = call.check("the stream to continue", 0); !sound) {
    return state_->explained(std::move(sound));
  }
  return state_->status_of(call);
}

/// The step waits for the frames, so their answers have arrived when it ends.
Outcome AxisGroup::State::stream_stepping(const Round& round) const {
  AxesCall& call = stream->call;
  const std::uint64_t ticks = stream->options.pace == Pace::drive ? 1 : 0;
  std::vector<SentFrames> sent;
  Outcome outcome = call.send({&round, 1}, 0, sent);
  if (outcome) outcome = call.axes().advance(ticks);
  return call.collect(sent, std::move(outcome)).outcome;
}

/// Set-points are sent for consecutive ticks. Each is answered in its tick, and the caller waits
/// for that answer, so the clock of the bench paces the stream.
Outcome AxisGroup::State::stream_ahead(const Round& round) const {
  const std::uint64_t lead = lead_of(*stream);
  if (stream->next_tick == 0) {
    const auto newest = stream->call.axes().newest_tick();
    if (!newest) return newest.outcome();
    stream->next_tick = *newest + lead;
  }
  std::vector<SentFrames>& sent = stream->in_flight.emplace_back();
  Outcome outcome = stream->call.send({&round, 1}, stream->next_tick++, sent);
  while (outcome && stream->in_flight.size() >= lead) outcome = collect_oldest();
  if (!outcome) {  // restart: the next set-point is as far ahead as the first one was
    collect_rest();
    stream->next_tick = 0;
  }
  return outcome;
}

Outcome AxisGroup::State::collect_oldest() const {
  const Answers answers = stream->call.collect(stream->in_flight.front(), {});
  stream->in_flight.pop_front();
  if (!answers.outcome) return answers.outcome;
  while (stream->call.tick() < answers.tick) {
    if (Outcome seen = stream->call.axes().advance(1); !seen) return seen;
  }
  return {};
}

/// Discards the remaining answers, which no longer matter.
void AxisGroup::State::collect_rest() const {
  while (!stream->in_flight.empty()) {
    (void)stream->call.collect(stream->in_flight.front(), {});
    stream->in_flight.pop_front();
  }
}

Outcome AxisGroup::stop_streaming(const GroupCallOptions& options) {
  if (Outcome here = state_->core->discovery.check_process(); !here) return here;
  if (!state_->stream) return not_in_this_state("streaming was not started");
  // Before the stream is ended: if this throws, the program calls again, and that call must still
  // find a stream to end.
  state_->core->failure.rethrow();
  Outcome rest;
  while (rest && !state_->stream->in_flight.empty()) rest = state_->collect_oldest();
  state_->collect_rest();
  const std::vector<std::size_t> released = std::move(state_->stream->released);
  state_->stream.reset();
  AxesCall call = state_->call(options);
  if (Outcome ready = call.begin_control(timeout_of(options)); !ready) return ready;
  Round mode = mode_round(call, OperatingMode::profile_position);
  for (const std::size_t place : released) {  // bit 4 must be 0 before its next edge
    if (is_enabled(call.snapshots()[place])) {
      add_word(mode.entries[place].command, kEnableOperation);
    }
  }
  const Answers answers = call.exchange({&mode, 1}, Timing::at_once);
  if (!answers.outcome) return state_->explained(answers.outcome);
  const bool to_the_end = options.until == Until::done;
  Outcome seen = call.await("profile position mode", answers.tick, [&](const AxisSnapshot& axis) {
    return !to_the_end || axis.mode() == OperatingMode::profile_position;
  });
  if (seen && to_the_end) {  // an axis that was moving braked before it changed its mode
    for (const BenchPart& part : call.axes().parts()) {
      state_->core->held_axes.forget_running(part.target.key, part.bench->axes);
    }
  }
  // A late set-point was not executed: the axes are not at rest where the caller expects them.
  return seen ? rest : seen;
}

}  // namespace vdrive::client
