// SPDX-License-Identifier: Apache-2.0
#include "bench_engine.hpp"

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>

namespace vdrive::service {
namespace {

constexpr std::uint16_t kStateBits = 0x006F;
constexpr std::size_t kParametersPerTick = 16;
constexpr std::size_t kNumbers = 65'536;
constexpr ObjectAddress kControlword{0x6040, 0};

std::uint64_t to_ticks(std::chrono::microseconds time, std::chrono::microseconds period) {
  return static_cast<std::uint64_t>((time + period - std::chrono::microseconds{1}) / period);
}

}  // namespace

BenchEngine::BenchEngine(const Configuration& configuration, const BenchIdentity& identity,
                         Outbox& outbox, Counters& counters)
    : identity_(identity),
      clock_(configuration.clock),
      period_(configuration.period),
      watchdog_(effective_watchdog(configuration)),
      rate_(clock_ == ClockMode::realtime ? configuration.rate : 0.0),
      furthest_ahead_(to_ticks(kFurthestAhead, configuration.period)),
      outbox_(outbox),
      counters_(counters),
      bank_(bank_axes(configuration), configuration.period),
      pool_(bank_, configuration.threads),
      control_(configuration.axes.size()),
      requests_([](msg::Reply& reply) {
        reply.objects().reserve(msg::MAX_OBJECTS_PER_REQUEST);
      }),
      commands_([](msg::CommandReply& reply) {
        reply.refusals().reserve(msg::MAX_AXES_PER_FRAME);
        reply.ignored_set_points().reserve(msg::MAX_AXES_PER_FRAME);
      }),
      indices_(kNumbers, static_cast<std::uint16_t>(kMaxAxes)),
      seen_(configuration.axes.size()),
      named_in_(configuration.axes.size()),
      skipped_(msg::MAX_AXES_PER_FRAME),
      changed_axes_(configuration.axes.size()),
      is_changed_(configuration.axes.size()) {
  for (const auto& axis : configuration.axes) {
    indices_[axis.number] = static_cast<std::uint16_t>(numbers_.size());
    numbers_.push_back(axis.number);
  }
  snapshots_.reserve(kMostSnapshots);
  stretch_watchdog();
  counters_.rate = rate_;
  undo_.reserve(std::size_t{msg::MAX_AXES_PER_FRAME} * (msg::MAX_OBJECTS_PER_AXIS + 8));
  command_reply_.refusals().reserve(msg::MAX_AXES_PER_FRAME);
  command_reply_.ignored_set_points().reserve(msg::MAX_AXES_PER_FRAME);
  frame_refusal_.refusals().resize(1);
  due_frame_.axes().reserve(msg::MAX_AXES_PER_FRAME);
  for (std::size_t axis = 0; axis < bank_.size(); ++axis) {
    seen_[axis].statusword = bank_.status(axis).ds402_statusword;
  }
}

void BenchEngine::start_at(std::uint64_t last_tick) {
  tick_ = last_tick;
  counters_.tick.set(tick_);
}

void BenchEngine::record_to(Journal& journal) {
  journal.begin(bank_, tick_);
  journal_ = &journal;
}

bool BenchEngine::can_answer() const noexcept {
  const auto& frames = outbox_.command_replies;
  return outbox_.replies.size() < outbox_.replies.capacity() &&
         frames.capacity() - frames.size() > pending_.size();
}

void BenchEngine::handle(Arrival& arrival) {
  if (arrival.kind == Arrival::Kind::command_frame) {
    handle_frame(arrival);
  } else {
    handle_request(arrival);
  }
}

void BenchEngine::step() {
  apply_due_frames();
  watch_masters();
  if (braking_) {
    for (std::size_t axis = 0; axis < numbers_.size(); ++axis) switch_off_at_rest(axis);
  }
  pool_.step();
  ++tick_;
  counters_.tick.set(tick_);
  counters_.ticks_run.add();
  counters_.pending_frames.set(pending_.size());
  if (journal_ != nullptr) journal_->record_tick(bank_, tick_);
  observe();
  static_cast<void>(answer_stores());
  post_parameters();
}

void BenchEngine::post_status(bool repeated) {
  StatusImage* const image = outbox_.status.free_slot();
  if (image == nullptr) {
    counters_.queue_overflows.add();
    return;
  }
  image->tick = tick_;
  image->repeated = repeated;
  for (std::size_t axis = 0; axis < bank_.size(); ++axis) image->status[axis] = bank_.status(axis);
  const auto owners = control_.owners();
  std::ranges::copy(owners, image->owners.begin());
  outbox_.status.push();
}

void BenchEngine::post_parameters() {
  tell_overflows();
  tell_journal();
  for (std::size_t count = 0; count < kParametersPerTick && changed_count_ > 0; ++count) {
    msg::AxisParameters* const slot = outbox_.parameters.free_slot();
    if (slot == nullptr) {
      return;  // they stay marked; later changes of the same axis join them
    }
    const std::size_t axis = changed_axes_[first_changed_];
    first_changed_ = (first_changed_ + 1) % changed_axes_.size();
    --changed_count_;
    is_changed_[axis] = false;
    wire::to_message(bank_, axis, {identity_.bench, numbers_[axis]}, tick_, *slot);
    outbox_.parameters.push();
  }
}

void BenchEngine::jump(std::uint64_t ticks) {
  tick_ += ticks;
  for (auto& record : control_.sessions()) record.last_heard_tick += ticks;
  counters_.tick.set(tick_);
  counters_.jumps.add();
  report({.kind = msg::EVENT_TICK_JUMPED, .detail = Count{ticks}});
}

void BenchEngine::report_overrun(std::chrono::nanoseconds late) {
  counters_.overruns.add();
  report({.kind = msg::EVENT_TICK_OVERRUN,
          .detail = std::chrono::floor<std::chrono::microseconds>(
              std::max(late, std::chrono::nanoseconds::zero()))});
}

std::optional<std::size_t> BenchEngine::index_of(std::uint16_t number) const noexcept {
  const std::uint16_t index = indices_[number];
  return index < numbers_.size() ? std::optional<std::size_t>(index) : std::nullopt;
}

AbortCode BenchEngine::write(std::size_t axis, ObjectAddress address, std::int64_t value) {
  const bool may_halt = address == kControlword && pending_.size() > 0 &&
                        (value & Controlword::kHalt) != 0 &&
                        (bank_.read(axis, kControlword).value & Controlword::kHalt) == 0;
  const AbortCode code = bank_.write(axis, address, value);
  if (code == AbortCode::none) {
    to_journal({.axis = static_cast<std::uint16_t>(axis), .address = address, .value = value});
    mark_changed(axis);
    if (may_halt) drop_pending_of_axis(numbers_[axis]);
  }
  return code;
}

/// Masters live by the wall clock: where drive time runs faster, so does the time that they have.
void BenchEngine::stretch_watchdog() {
  if (!watchdog_) {
    watchdog_ticks_ = 0;
    return;
  }
  const auto time = std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::duration<double, std::milli>(*watchdog_) * std::max(rate_, 1.0));
  watchdog_ticks_ = to_ticks(time, period_);
}

void BenchEngine::watch_masters() {
  if (watchdog_ticks_ == 0 || braking_) return;
  for (auto& record : control_.sessions()) {
    if (record.owned_axes > 0 && tick_ - record.last_heard_tick > watchdog_ticks_) {
      lose_master(record);
    }
  }
}

void BenchEngine::lose_master(SessionRecord& record) {
  std::size_t lost = 0;
  std::uint16_t last_number = 0;
  for (std::size_t axis = 0; axis < numbers_.size(); ++axis) {
    if (control_.owner(axis).session == record.session) {
      bank_.report_connection_loss(axis);
      to_journal(
          {.kind = JournalChange::Kind::connection_loss, .axis = static_cast<std::uint16_t>(axis)});
      control_.take(axis);
      last_number = numbers_[axis];
      ++lost;
    }
  }
  control_.renew_epoch(record);
  record.must_acquire = true;
  drop_pending_of_session(record.session);
  counters_.master_losses.add();
  report({.kind = msg::EVENT_MASTER_LOST,
          .axis = lost == 1 ? last_number : std::uint16_t{0},
          .session = record.session,
          .detail = Count{lost}});
}

void BenchEngine::observe() {
  for (std::size_t axis = 0; axis < numbers_.size(); ++axis) {
    const AxisStatus& status = bank_.status(axis);
    Seen& seen = seen_[axis];
    if (((status.ds402_statusword ^ seen.statusword) & kStateBits) != 0) {
      observe_state(axis, status, seen);
    }
    if (status.fault_count != seen.fault_count) {
      if (status.fault_count > seen.fault_count) {
        report({.kind = msg::EVENT_FAULT,
                .axis = numbers_[axis],
                .code = status.error_code,
                .error_register = status.error_register});
      }
      seen.fault_count = status.fault_count;
    }
    if (status.ignored_set_points != seen.ignored_set_points) {
      if (status.ignored_set_points > seen.ignored_set_points) {
        const std::uint32_t more = status.ignored_set_points - seen.ignored_set_points;
        counters_.set_points_ignored.add(more);
        report({.kind = msg::EVENT_SET_POINT_IGNORED,
                .axis = numbers_[axis],
                .session = control_.owner(axis).session,
                .detail = Count{more}});
      }
      seen.ignored_set_points = status.ignored_set_points;
    }
    seen.statusword = status.ds402_statusword;
    seen.error_code = status.error_code;
  }
}

void BenchEngine::observe_state(std::size_t axis, const AxisStatus& status, Seen& seen) {
  const PowerState before = decode_power_state(seen.statusword);
  report({.kind = msg::EVENT_STATE_CHANGED,
          .axis = numbers_[axis],
          .code = status.ds402_statusword,
          .error_register = status.error_register});
  if (before == PowerState::fault) {
    report({.kind = msg::EVENT_FAULT_RESET,
            .axis = numbers_[axis],
            .code = seen.error_code,
            .error_register = status.error_register});
  }
  if (before == PowerState::operation_enabled && pending_.size() > 0) {
    drop_pending_of_axis(numbers_[axis]);
  }
}

void BenchEngine::mark_changed(std::size_t axis) {
  if (!is_changed_[axis]) {
    is_changed_[axis] = true;
    changed_axes_[(first_changed_ + changed_count_) % changed_axes_.size()] =
        static_cast<std::uint16_t>(axis);
    ++changed_count_;
  }
}

void BenchEngine::report(EventRecord event) {
  event.tick = tick_;
  if (EventRecord* const slot = outbox_.events.free_slot(); slot != nullptr) {
    *slot = event;
    outbox_.events.push();
  } else {
    counters_.queue_overflows.add();
  }
}

void BenchEngine::to_journal(const JournalChange& change) {
  if (journal_ != nullptr) journal_->record(change);
}

void BenchEngine::tell_journal() {
  while (journal_ != nullptr && outbox_.events.free_slot() != nullptr) {
    const auto news = journal_->news();
    if (!news) return;
    report({.kind = msg::EVENT_JOURNAL, .code = news->code, .detail = news->detail});
  }
}

/// Every full queue is counted, in whatever thread; the news waits until there is room for it.
void BenchEngine::tell_overflows() {
  const std::uint64_t overflows = counters_.queue_overflows.get();
  if (overflows != told_overflows_ && outbox_.events.free_slot() != nullptr) {
    report({.kind = msg::EVENT_QUEUE_OVERFLOW, .detail = Count{overflows - told_overflows_}});
    told_overflows_ = overflows;
  }
}

}  // namespace vdrive::service
