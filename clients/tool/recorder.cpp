// SPDX-License-Identifier: Apache-2.0
#include "recorder.hpp"

#include "report.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <system_error>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;

/// Short where several benches take turns: none may wait long for another that stands still.
constexpr std::chrono::milliseconds kPatienceOfOne{100};
constexpr std::chrono::milliseconds kPatienceOfMany{5};

/// Objects of the status image, the columns of a recording.
std::vector<ObjectRow> recorded_objects() {
  std::vector<ObjectRow> rows;
  for (std::size_t row = 0; row < kObjectCount; ++row) {
    const auto object = static_cast<ObjectRow>(row);
    if (value_of(AxisStatus{}, object)) rows.push_back(object);
  }
  return rows;
}

const std::vector<ObjectRow>& columns() {
  static const std::vector<ObjectRow> rows = recorded_objects();
  return rows;
}

std::string system_error() {
  return std::generic_category().message(errno);
}

}  // namespace

std::string recording_header() {
  std::string header = "axis,name,tick,missed";
  for (const ObjectRow row : columns()) {
    header.append(",").append(describe(row).variable_name);
  }
  return header + ",ignored_set_points,fault_count,owner,owner_epoch";
}

/// One bench on its way through the recording.
struct Recorder::Track {
  Track(client::Follower stream, std::chrono::milliseconds wait)
      : follower(std::move(stream)), patience(wait) {}

  client::Follower follower;
  std::chrono::milliseconds patience;
  std::uint64_t ticks = 0;  ///< to record; 0 = without end
  std::optional<std::uint64_t> first_tick;
  std::uint64_t samples = 0;
  bool has_ended = false;
};

Recorder::Recorder(client::Session& session, Terminal& terminal, const RecordCommand& command,
                   std::map<client::AxisId, std::string> names)
    : session_(session), terminal_(terminal), command_(command), names_(std::move(names)) {}

Outcome Recorder::record(const std::vector<RecordedBench>& benches) {
  std::ofstream file;
  if (command_.file != "-") {
    file.open(command_.file, std::ios::trunc);
    if (!file)
      return Outcome::failed("cannot write " + in_quotes(command_.file) + ": " + system_error());
    file_ = &file;
  }
  std::vector<Track> tracks;
  for (const RecordedBench& bench : benches) {
    auto follower = session_.follow(bench.axes, client::Pace::observe);
    if (!follower) return follower.outcome();
    Track track{std::move(*follower), benches.size() == 1 ? kPatienceOfOne : kPatienceOfMany};
    if (command_.duration) track.ticks = client::ticks_of(*command_.duration, bench.info.period);
    tracks.push_back(std::move(track));
  }
  has_begun_ = true;
  if (command_.format == RecordFormat::csv) put(recording_header());
  Outcome outcome = follow(tracks);
  if (file_ != nullptr && !file.flush() && outcome) {
    outcome = Outcome::failed("cannot write " + in_quotes(command_.file) + ": " + system_error());
  }
  return outcome;
}

Outcome Recorder::follow(std::vector<Track>& tracks) {
  bool goes_on = true;
  while (goes_on && terminal_.is_open()) {
    goes_on = false;
    for (Track& track : tracks) {
      if (Outcome seen = take_sample(track); !seen) return seen;
      goes_on = goes_on || !track.has_ended;
    }
  }
  return {};
}

Outcome Recorder::take_sample(Track& track) {
  if (track.has_ended) return {};
  const auto sample = track.follower.next(track.patience);
  if (sample.outcome().kind() == OutcomeKind::timed_out) return {};
  if (!sample) return sample.outcome();
  if (!track.first_tick) track.first_tick = sample->tick;
  if (track.ticks != 0 && sample->tick - *track.first_tick >= track.ticks) {
    track.has_ended = true;
    return {};
  }
  write(*sample);
  ++track.samples;
  track.has_ended = track.samples == command_.count;
  if (file_ == nullptr || *file_) return {};
  return Outcome::failed("cannot write " + in_quotes(command_.file) + ": " + system_error());
}

void Recorder::write(const client::Observation& sample) {
  ++samples_;
  lost_ += sample.missed;
  for (const client::AxisSnapshot& axis : sample.axes) {
    put(command_.format == RecordFormat::csv ? csv_row(axis, sample.missed)
                                             : json_row(axis, sample.missed));
  }
}

std::string Recorder::csv_row(const client::AxisSnapshot& axis, std::uint64_t missed) const {
  std::string row = to_string(axis.id) + "," + csv_field(names_.at(axis.id)) + "," +
                    std::to_string(axis.tick) + "," + std::to_string(missed);
  for (const ObjectRow object : columns()) {
    row.append(",").append(std::to_string(*value_of(axis.status, object)));
  }
  row.append(",").append(std::to_string(axis.status.ignored_set_points));
  row.append(",").append(std::to_string(axis.status.fault_count));
  row.append(",");
  if (axis.owner_session != 0) row.append(session_text(axis.owner_session));
  return row + "," + std::to_string(axis.owner_epoch);
}

std::string Recorder::json_row(const client::AxisSnapshot& axis, std::uint64_t missed) const {
  Json json = status_json(axis, names_.at(axis.id));
  json["missed"] = missed;
  return to_line(json);
}

void Recorder::put(const std::string& line) {
  if (file_ == nullptr) {
    terminal_.print(line);
  } else {
    *file_ << line << '\n';
  }
}

}  // namespace vdrive::tool
