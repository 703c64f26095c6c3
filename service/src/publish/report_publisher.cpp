// SPDX-License-Identifier: Apache-2.0
#include "publish/report_publisher.hpp"

#include "base/log.hpp"
#include "publish/event_text.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/conversion.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>
#include <thread>
#include <utility>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;
using namespace vdrive::literals;

constexpr std::chrono::seconds kRateWindow{1};  // long compared to the jitter of a tick
constexpr std::chrono::milliseconds kReportInterval{100};
constexpr const char* kUnit = "UU";
/// As deep as the history of the topic.
constexpr auto kEventsKept = static_cast<std::size_t>(wire::Topic<msg::Event>::kRow.quality.depth);
/// A wire that does not empty a lane in this time is hung.
constexpr std::chrono::milliseconds kLongestWaitForRoom{100};

std::int64_t read(const AxisBank& bank, std::size_t axis, ObjectRow row) {
  return bank.read(axis, describe(row).address).value;
}

template <typename Value, typename Source>
void fill(const FigureRow<Value, Source>& row, const Counters& counters, msg::BenchState& state) {
  state.*row.figure = static_cast<Value>((counters.*row.source).get());
}

template <typename Source>
void fill(const MetricRow<Source>& /*row*/, const Counters& /*counters*/,
          msg::BenchState& /*state*/) {}

void fill_figures(const Counters& counters, msg::BenchState& state) {
  std::apply(
      [&](const auto&... rows) {
        (fill(rows, counters, state), ...);
      },
      kCounterRows);
}

}  // namespace

ReportPublisher::ReportPublisher(WireLink& link, const Configuration& configuration,
                                 const BenchIdentity& identity, const AxisBank& bank,
                                 Counters& counters)
    : link_(link),
      identity_(identity),
      period_(configuration.period),
      counters_(counters),
      indices_(end_of_numbers(configuration)),
      sessions_(identity.bench) {
  describe_axes(configuration, bank);
  for (std::size_t axis = 0; axis < configuration.axes.size(); ++axis) {
    wire::to_message(bank, axis, {identity.bench, configuration.axes[axis].number}, 0,
                     parameters_.emplace_back());
    indices_[configuration.axes[axis].number] = static_cast<std::uint16_t>(axis);
  }
  state_.bench = identity.bench;
  state_.incarnation = identity.incarnation;
  state_.clock_mode = wire::to_message(configuration.clock);
  event_.bench = identity.bench;
  event_.incarnation = identity.incarnation;
}

void ReportPublisher::describe_axes(const Configuration& configuration, const AxisBank& bank) {
  constexpr std::size_t kPartSize = msg::MAX_AXES_PER_FRAME;
  const std::size_t count = configuration.axes.size();
  const std::size_t parts = (count + kPartSize - 1) / kPartSize;
  for (std::size_t part = 0; part < parts; ++part) {
    auto& description = parts_.emplace_back();
    description.bench = identity_.bench;
    description.part = static_cast<std::uint16_t>(part);
    description.parts = static_cast<std::uint16_t>(parts);
    description.incarnation = identity_.incarnation;
    description.clock_mode = wire::to_message(configuration.clock);
    description.period_us = static_cast<std::uint32_t>(configuration.period.count());
    description.status_every_ticks = configuration.status_every;
    description.dictionary_version = std::string(kDictionaryVersion);
    description.service_version = std::string(VDRIVE_VERSION);
    description.name = configuration.name;
    description.position_unit = kUnit;
    description.velocity_unit = std::string(kUnit) + "/s";
    description.acceleration_unit = std::string(kUnit) + "/s2";
    description.user_units_per_revolution = kUserUnitsPerRevolution;
    description.axis_count = static_cast<std::uint32_t>(count);
    for (std::size_t axis = part * kPartSize; axis < std::min(count, (part + 1) * kPartSize);
         ++axis) {
      auto& entry = description.axes.emplace_back();
      entry.axis = configuration.axes[axis].number;
      entry.name = configuration.axes[axis].name;
      entry.supported_drive_modes =
          static_cast<std::uint32_t>(read(bank, axis, "supported_drive_modes"_object));
      entry.user_position_lower_limit =
          static_cast<std::int32_t>(read(bank, axis, "user_position_lower_limit"_object));
      entry.user_position_upper_limit =
          static_cast<std::int32_t>(read(bank, axis, "user_position_upper_limit"_object));
      entry.app_speed_limit =
          static_cast<std::uint32_t>(read(bank, axis, "app_speed_limit"_object));
      wire::to_message(configuration.axes[axis].unit, entry);
    }
  }
}

void ReportPublisher::announce(bool alive) {
  for (auto& part : parts_) part.alive = alive;
  met_ = link_.running();
  for (const auto& part : parts_) write(part);
  has_history_ = !alive;  // a bench that has ended reports nothing more
  link_.flush(Lane::reports);
}

/// Gives a new wire everything that late readers need; the wire keeps it for them while it runs.
void ReportPublisher::send_history() {
  const std::uint32_t running = link_.running();
  if (running != met_) {
    met_ = running;
    has_history_ = false;
    for (const auto& part : parts_) write(part);
  }
  if (met_ == 0 || has_history_) return;
  has_history_ = true;
  for (auto& parameters : parameters_) {
    if (parameters.tick == 0) parameters.tick = counters_.tick.get();
    write(parameters);
  }
  for (const auto& event : history_) write(event);
  sessions_.begin_again();
}

void ReportPublisher::publish(Inbox& inbox, Outbox& outbox) {
  // Measure the queues before they are emptied.
  counters_.inbox_depth.set(inbox.size());
  counters_.outbox_depth.set(outbox.size());
  send_history();
  publish_events(outbox);
  publish_parameters(outbox);
  publish_sessions();
  if (const auto now = Clock::now(); link_.take_state_request() || now >= next_state_) {
    publish_state(now);
    next_state_ = now + kStateInterval;
  }
  link_.flush(Lane::reports);
}

void ReportPublisher::publish_events(Outbox& outbox) {
  const auto now = std::chrono::nanoseconds(Clock::now().time_since_epoch());
  passed_.clear();
  while (const EventRecord* const event = outbox.events.front()) {
    limiter_.offer(*event, now, passed_);
    outbox.events.pop();
  }
  if (now >= next_flush_) {
    limiter_.flush(now, passed_);
    next_flush_ = now + kReportInterval;
  }
  for (const auto& counted : passed_) publish_event(counted);
}

void ReportPublisher::publish_event(const CountedEvent& counted) {
  const auto& [event, suppressed] = counted;
  const std::string text = words_of(event);
  event_.tick = event.tick;
  event_.time_ns = static_cast<std::int64_t>(event.tick) * period_.count();
  event_.kind = event.kind;
  event_.axis = event.axis;
  event_.session = event.session;
  event_.code = event.code;
  event_.error_register = event.error_register;
  event_.suppressed = static_cast<std::uint32_t>(
      std::min<std::uint64_t>(suppressed, std::numeric_limits<std::uint32_t>::max()));
  event_.text = text;
  if (history_.size() == kEventsKept) history_.pop_front();
  history_.push_back(event_);
  write(event_);
  counters_.events_sent.add();
  if (const auto level = level_of(event); is_logged(level)) {
    spdlog::log(level, log_line(identity_.bench, event, suppressed));
  }
}

void ReportPublisher::publish_parameters(Outbox& outbox) {
  parameter_samples_.refill(Clock::now().time_since_epoch());
  while (!parameter_samples_.is_empty()) {
    const msg::AxisParameters* const parameters = outbox.parameters.front();
    if (parameters == nullptr) return;
    parameters_[indices_[parameters->axis]] = *parameters;
    write(*parameters);
    outbox.parameters.pop();
    static_cast<void>(parameter_samples_.take());
  }
}

void ReportPublisher::note_session(std::span<const std::byte> sample) {
  if (!wire::decode(sample, received_name_) || !sessions_.note(received_name_)) return;
  log_debug(R"(bench={} session={} program="{}" process={} host="{}")", identity_.bench,
            session_text(received_name_.session), escaped(received_name_.program.to_string()),
            received_name_.process, escaped(received_name_.host.to_string()));
}

void ReportPublisher::publish_sessions() {
  if (met_ == 0 || sessions_.next() == nullptr) return;
  session_samples_.refill(Clock::now().time_since_epoch());
  while (sessions_.next() != nullptr && session_samples_.take()) {
    write(*sessions_.next());
    sessions_.pop();
  }
}

void ReportPublisher::publish_state(Clock::time_point now) {
  const auto [tick, skipped] = counters_.tick.read();
  state_.tick = tick;
  state_.skipped_ticks = static_cast<std::uint32_t>(skipped);
  state_.time_ns = static_cast<std::int64_t>(tick) * period_.count();
  state_.rate = counters_.rate.get();
  state_.measured_rate = measured_rate(tick, now);
  state_.steppers = static_cast<std::uint32_t>(counters_.steppers.get());
  state_.slowest_stepper = counters_.slowest_stepper.get();
  state_.snapshots = static_cast<std::uint32_t>(counters_.snapshots.get());
  state_.lateness_histogram.clear();
  for (const auto& bin : counters_.lateness) state_.lateness_histogram.push_back(bin.get());
  fill_figures(counters_, state_);
  write(state_);
}

double ReportPublisher::measured_rate(std::uint64_t tick, Clock::time_point now) {
  const auto wall = now - rate_time_;
  if (wall >= kRateWindow) {
    if (rate_time_ != Clock::time_point{}) {
      const std::chrono::duration<double> drive =
          period_ * static_cast<std::int64_t>(tick - rate_tick_);
      measured_rate_ = drive.count() / std::chrono::duration<double>(wall).count();
    }
    rate_time_ = now;
    rate_tick_ = tick;
  }
  return measured_rate_;
}

/// Does nothing without a wire: the history keeps the message. A burst, such as the descriptions of
/// all axes, waits for the wire to make room.
template <typename Message>
void ReportPublisher::write(const Message& message) {
  if (met_ == 0) return;
  bool is_posted = link_.post(Lane::reports, message);
  // Wait only once for a wire that hangs, not once per message: this thread also judges the wire.
  const auto deadline = Clock::now() + (is_lane_stuck_ ? 0ms : kLongestWaitForRoom);
  while (!is_posted && link_.running() == met_ && Clock::now() < deadline) {
    link_.flush(Lane::reports);
    std::this_thread::yield();
    is_posted = link_.post(Lane::reports, message);
  }
  is_lane_stuck_ = !is_posted;
  if (!is_posted) counters_.queue_overflows.add();
}

}  // namespace vdrive::service
