// SPDX-License-Identifier: Apache-2.0
#include "simulation/bench.hpp"

#include "base/event_codes.hpp"
#include "base/reason.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::simulation {
namespace {

constexpr std::uint64_t kSabotageFrom = 200;  // [ticks], when axes are enabled and moving
constexpr std::uint64_t kRepeatEach = 1'009;  // [ticks]
constexpr int kRepeatedTicks = 20;
constexpr std::size_t kEncoderFailure = 4;  // index among the inputs from 5E00h on
constexpr unsigned kCountedBack = 5'000;    // more edges than 16 ticks can have

/// The configuration as a broken service would use it.
service::Configuration as_taken(service::Configuration configuration, Sabotage sabotage) {
  if (sabotage == Sabotage::watchdog_bites_early) {
    configuration.watchdog = *configuration.watchdog / 2;
  }
  if (sabotage == Sabotage::watchdog_sleeps) configuration.watchdog.reset();
  for (auto& axis : configuration.axes) {
    if (sabotage == Sabotage::no_reaction_to_a_loss) {
      axis.configuration.parameters.push_back({{0x6007, 0}, 0});
    }
  }
  return configuration;
}

}  // namespace

Bench::Bench(const service::Configuration& configuration, const std::vector<test::DrawnAxis>& axes,
             std::uint64_t incarnation, SimulatedTime& time, Storage* storage, Sabotage sabotage,
             Happenings& happenings)
    : configuration_(configuration),
      incarnation_(incarnation),
      time_(time),
      storage_(storage),
      sabotage_(sabotage),
      happenings_(happenings),
      inbox_(configuration.bench, counters_),
      outbox_(configuration.axes.size()),
      as_started_(as_taken(configuration, sabotage)),
      engine_((start_storage(), as_started_),
              {.bench = configuration.bench, .incarnation = incarnation}, outbox_, counters_),
      model_(configuration, incarnation, happenings) {
  if (configuration.clock == service::ClockMode::realtime) {
    realtime_.emplace(configuration, engine_, inbox_, counters_, time);
  } else if (configuration.clock == service::ClockMode::freerun) {
    freerun_.emplace(engine_, inbox_, outbox_, time);
  }
  model_.start_at(engine_.tick());
  if (saver_) {
    engine_.store_with(*saver_);
    model_.store_with(storage_->model, loaded_);
  }
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    watches_.emplace_back(axes[axis].limits, configuration.period);
    watches_.back().begin(engine_.bank().status(axis), engine_.bank().power_state(axis));
    probes_.emplace_back(static_cast<std::uint16_t>(axis + 1), axes[axis].limits);
  }
  engine_.queue_status();
  take_images();
}

void Bench::receive(const ClientMessage& message) {
  const std::size_t before = inbox_.size();
  if (!spoil(message)) {
    std::visit(
        [&](const auto& sent) {
          inbox_.receive(sent, {});
        },
        message);
  }
  if (inbox_.size() > before) {
    in_inbox_.push_back(message);
  } else {
    ++turned_away_;
  }
}

/// The bench takes messages in the order of their arrival: a message that has left the inbox was
/// taken.
void Bench::count_arrivals() {
  while (in_inbox_.size() > inbox_.size()) {
    std::visit(
        [&](const auto& sent) {
          model_.arrive(sent);
        },
        in_inbox_.front());
    in_inbox_.pop_front();
  }
}

/// The state directory as a service finds it at its start.
void Bench::start_storage() {
  if (storage_ == nullptr) return;
  if (sabotage_ == Sabotage::syncs_nothing) storage_->disk.lie();
  auto store = std::make_unique<service::ParameterStore>(Disk::kDirectory, configuration_.bench,
                                                         storage_->disk.files());
  service::LoadedParameters loaded = store->load();
  if (sabotage_ == Sabotage::stores_half && !loaded.table.empty()) {
    loaded.table.erase(loaded.table.begin());
  }
  for (const auto& [axis, values] : loaded.table) {
    StoredValues& stored = loaded_[axis];
    for (const InitialValue& value : values) {
      if (value.address == ObjectAddress{0x6067, 0}) {
        stored.stamp = static_cast<std::uint32_t>(value.value);
      } else if (value.address == ObjectAddress{0x6081, 0}) {
        stored.velocity = static_cast<std::uint32_t>(value.value);
      }
    }
    if (values.size() != kStoredRows.size()) {
      happenings_.fail(Invariant::kStored, axis, std::to_string(kStoredRows.size()) + " values",
                       std::to_string(values.size()));
    }
  }
  storage_->model.start(loaded_, happenings_);
  for (const service::EventRecord& news : service::apply(loaded, as_started_)) {
    if (news.code != service::ParameterCode::kLoaded) {
      happenings_.fail(Invariant::kStored, news.axis, "every set usable",
                       std::get<service::StoredProblem>(news.detail).text());
    }
  }
  happenings_.record("loads the stored values of", {loaded_.size()});
  saver_.emplace(std::move(store), std::move(loaded.table));
}

/// The work of the saver's thread, some time after the first order.
void Bench::save() {
  if (!saver_ || storage_->model.waiting() == 0) return;
  if (!save_at_) {
    const bool is_slow = storage_->random.per_mille(100);
    save_at_ = time_.now + storage_->random.between(0, (is_slow ? 500 : 20) * kMillisecond);
  }
  if (time_.now < *save_at_) return;
  save_at_.reset();
  Disk& disk = storage_->disk;
  disk.begin_save();
  saver_->save_waiting();
  happenings_.record("saves", {storage_->model.waiting(), disk.has_failed() ? 1U : 0U});
  const bool is_doubtful = disk.has_replaced() || disk.is_killed();
  storage_->model.save(!disk.has_failed() ? StoreModel::Outcome::durable
                       : is_doubtful      ? StoreModel::Outcome::doubtful
                                          : StoreModel::Outcome::refused);
}

/// Checks how many orders the engine has taken back. While it can answer, it must take back saved
/// ones within a few cycles.
void Bench::take_back_stores() {
  constexpr std::uint64_t kMostIdle = 3;
  if (!saver_) return;
  const std::size_t on_their_way = service::ParameterSaver::kMostOrders - saver_->room();
  const std::size_t expected = storage_->model.waiting() + storage_->model.saved();
  const std::size_t taken = expected - std::min(expected, on_their_way);
  if (on_their_way > expected || taken > storage_->model.saved()) {
    happenings_.fail(Invariant::kAnswered, 0, std::to_string(expected) + " orders to store",
                     std::to_string(on_their_way));
    return;
  }
  model_.take_back_stores(taken);
  const bool may =
      storage_->model.saved() > 0 && outbox_.replies.size() + 1 < outbox_.replies.capacity();
  idle_stores_ = may && taken == 0 ? idle_stores_ + 1 : 0;
  if (idle_stores_ > kMostIdle) {
    happenings_.fail(Invariant::kAnswered, 0, "an answer to a store that is saved", "none");
  }
}

void Bench::cycle(const Mail& mail) {
  save();
  if (was_killed()) return;
  if (sabotage_ == Sabotage::resumes_by_itself && happenings_.tick() > kSabotageFrom) {
    enable_unrequested();
  }
  if (realtime_ || freerun_) {
    const std::uint64_t before = engine_.tick();
    if (realtime_) {
      realtime_->cycle();
    } else {
      // Not faster than images are published, so that every tick is observed.
      constexpr std::chrono::microseconds kStatus{service::FreerunDriver::kStatusInterval};
      time_.wait_until(std::chrono::nanoseconds{time_.now} +
                       std::max(configuration_.period, kStatus));
      freerun_->cycle();
    }
    count_arrivals();
    if (engine_.tick() > before) {
      if (const std::uint64_t left_out = engine_.tick() - before - 1; left_out > 0) {
        happenings_.record("time jumps", {left_out});
        model_.jump(left_out);
      }
      after_tick();
    } else {
      take_back_stores();
    }
  } else {
    time_.wait_until(std::chrono::nanoseconds{time_.now} + configuration_.period);
    cycle_lockstep();
  }
  take_images();
  take_events();
  take_answers(mail);
}

/// Works as the lock-step driver: requests in their order, steps immediately.
void Bench::cycle_lockstep() {
  static_cast<void>(engine_.answer_stores());
  take_back_stores();
  while (engine_.can_answer()) {
    service::Arrival* const arrival = inbox_.front();
    if (arrival == nullptr) return;
    if (service::StepRequests::is_for(*arrival)) {
      step_by_request(*arrival);
      inbox_.pop();
      in_inbox_.pop_front();
    } else {
      engine_.handle(*arrival);
      inbox_.pop();
      count_arrivals();
    }
  }
}

void Bench::step_by_request(service::Arrival& arrival) {
  service::StepRequests& steps = engine_.steps();
  const service::StepRequests::Time now{};
  const msg::Request request = arrival.request;  // a waiting step takes it
  const bool is_repeat = !steps.handle(arrival, now);
  if (is_repeat != model_.is_repeat(request)) {
    happenings_.fail(Invariant::kAnswered, 0, is_repeat ? "a step that is new" : "a repeated step",
                     "the other");
  }
  if (is_repeat) return;
  const bool has_frames = model_.has_frames_of(request);
  const std::uint64_t ticks = steps.ticks_to_run(now);
  const std::uint64_t expected = has_frames ? request.ticks : 0;
  if (ticks != expected) {
    happenings_.fail(Invariant::kAnswered, 0, std::to_string(expected) + " ticks",
                     std::to_string(ticks));
  }
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    steps.begin_tick();
    model_.note_message(request.session);
    engine_.step();
    engine_.queue_status();
    after_tick();
  }
  steps.answer_due(service::StepRequests::Time::max());  // nobody waits any longer
  model_.expect_step_answer(request,
                            has_frames ? msg::Reason::none : msg::Reason::missing_commands);
}

/// Compares the published tick with the expectations of the model and the watches.
void Bench::after_tick() {
  happenings_.next_tick();
  model_.begin_tick();
  take_back_stores();
  take_images();
  const AxisBank& bank = engine_.bank();
  for (std::size_t axis = 0; axis < watches_.size(); ++axis) {
    const AxisStatus& status = image_.status[axis];
    test::AxisCauses causes = model_.causes(axis);
    causes.restored = model_.was_restored();
    causes.has_test_input = model_.registers(axis).has_test_input();
    causes.encoder_fails = model_.registers(axis).test_inputs[kEncoderFailure] != 0;
    watches_[axis].check(status, bank.power_state(axis), causes);
    if (const auto& violation = watches_[axis].violation()) {
      happenings_.fail(violation->invariant, axis + 1, violation->expected, violation->seen);
    }
    happenings_.add(static_cast<std::uint32_t>(status.position_demand_value) ^
                    std::uint64_t{status.ds402_statusword} << 48U);
    happenings_.add(static_cast<std::uint32_t>(status.load_position_actual_value) ^
                    image_.owners[axis].session);
  }
  if (image_.tick != model_.tick()) {
    happenings_.fail(Invariant::kCommanded, 0, "tick " + std::to_string(model_.tick()),
                     "tick " + std::to_string(image_.tick));
  }
  evaluate_probes();
  if (happenings_.tick() % kRepeatEach == 0) check_repeat();
  model_.check_owners(image_.owners);
  take_parameters();
  model_.end_tick(image_.status);
}

/// Checks one axis in each tick: checking all would take as long as the tick.
void Bench::evaluate_probes() {
  if (model_.was_restored()) {
    for (ProbeWatch& probe : probes_) probe.begin();
  }
  const std::size_t axis = happenings_.tick() % probes_.size();
  ProbeWatch::Look look = ProbeWatch::look_at(engine_.bank(), axis);
  if (sabotage_ == Sabotage::counts_back && happenings_.tick() > kSabotageFrom) {
    look.counters.front() = static_cast<std::uint16_t>(look.counters.front() - kCountedBack);
  }
  probes_[axis].check(look, probes_.size(), happenings_);
}

/// A copy of the axes takes a snapshot and runs, then is restored from the bytes of the snapshot
/// and runs again.
void Bench::check_repeat() {
  AxisBank axes = engine_.bank();
  const AxisBank::Snapshot before = axes.snapshot();
  for (int tick = 0; tick < kRepeatedTicks; ++tick) axes.step();
  const std::uint64_t first = axes.status_hash();
  axes.restore(axes.snapshot_from(before.bytes()));
  if (sabotage_ == Sabotage::restores_otherwise) {
    for (std::size_t axis = 0; axis < axes.size(); ++axis) axes.write(axis, {0x5E00, 0}, 2'000);
  }
  for (int tick = 0; tick < kRepeatedTicks; ++tick) axes.step();
  if (axes.status_hash() != first) {
    happenings_.fail(Invariant::kRepeat, 0, std::to_string(first),
                     std::to_string(axes.status_hash()));
  }
}

void Bench::take_images() {
  while (service::StatusImage* const image = outbox_.status.front()) {
    if (sabotage_ != Sabotage::none && happenings_.tick() > kSabotageFrom) spoil(*image);
    image_.tick = image->tick;
    std::swap(image_.status, image->status);
    std::swap(image_.owners, image->owners);
    image->status.resize(watches_.size());
    image->owners.resize(watches_.size());
    outbox_.status.pop();
  }
}

void Bench::take_events() {
  while (const service::EventRecord* const event = outbox_.events.front()) {
    happenings_.add(wire::number(event->kind) << 16U | event->axis);
    if (event->kind != msg::EventKind::state_changed && event->kind != msg::EventKind::refused) {
      happenings_.record("event",
                         {wire::number(event->kind), event->axis, event->session, event->code});
    }
    model_.check(*event);
    outbox_.events.pop();
  }
  model_.check_events();
}

/// Parameters belong to the current tick: nothing has arrived since.
void Bench::take_parameters() {
  while (const msg::AxisParameters* const parameters = outbox_.parameters.front()) {
    if (parameters->tick == model_.tick()) model_.check(*parameters);
    outbox_.parameters.pop();
  }
}

void Bench::take_answers(const Mail& mail) {
  while (const auto away = inbox_.next_turned_away()) {
    --turned_away_;
    happenings_.record("is turned away", {away->session, away->sequence_number, away->request_id});
  }
  if (time_.now < answers_held_until_) return;
  while (const service::OutgoingReply* const outgoing = outbox_.replies.front()) {
    happenings_.record("answers request",
                       {outgoing->reply.client, outgoing->reply.request_id,
                        wire::number(outgoing->reply.reason), outgoing->reply.epoch});
    if (sabotage_ == Sabotage::hides_store_failures &&
        outgoing->reply.reason == service::Reason(AbortCode::hardware_error)) {
      msg::Reply lie = outgoing->reply;
      lie.reason = msg::Reason::none;
      model_.check(lie);
    } else if (sabotage_ != Sabotage::forgets_an_answer || ++spoiled_ != 20) {
      model_.check(outgoing->reply);
    }
    mail.reply(outgoing->reply);
    outbox_.replies.pop();
  }
  while (const service::StoredCommandReply* const kept = outbox_.command_replies.front()) {
    msg::CommandReply reply;
    kept->show(reply);
    happenings_.record("answers frame",
                       {reply.session, reply.sequence_number, reply.tick,
                        reply.refusals.empty() ? 0 : wire::number(reply.refusals.front().reason)});
    model_.check(reply);
    if (sabotage_ == Sabotage::answers_twice && ++spoiled_ == 20) model_.check(reply);
    mail.command_reply(reply);
    outbox_.command_replies.pop();
  }
  model_.check_all_answered();
}

// ---- a broken service --------------------------------------------------------------------------

/// Enables the first axis without power, without a request.
void Bench::enable_unrequested() {
  const auto rests = std::ranges::find_if(image_.status, [](const AxisStatus& status) {
    return decode_power_state(status.ds402_statusword) == PowerState::switch_on_disabled;
  });
  if (rests == image_.status.end()) return;
  const auto axis = rests - image_.status.begin();
  const std::uint64_t owner = image_.owners[static_cast<std::size_t>(axis)].session;
  msg::Request request;
  request.client = 1;
  request.request_id = ++unrequested_;
  request.bench = configuration_.bench;
  request.session = owner == 0 ? 1 : owner;
  request.kind = msg::RequestKind::write;
  auto& object = request.objects.emplace_back();
  object.axis = static_cast<std::uint16_t>(axis + 1);
  object.index = 0x6040;
  object.value = 0x000F;
  inbox_.receive(request, {});
}

/// @return whether the engine received the message in a different form than it was sent.
bool Bench::spoil(const ClientMessage& message) {
  const auto* const sent = std::get_if<msg::CommandFrame>(&message);
  if (sabotage_ == Sabotage::none || sent == nullptr) return false;
  msg::CommandFrame frame = *sent;
  const auto held = std::ranges::find_if(image_.owners, [&](const wire::Ownership& owner) {
    return owner.session == frame.session;
  });
  switch (sabotage_) {
    case Sabotage::accepts_stale_epochs:
      if (held == image_.owners.end() || frame.epoch == held->epoch) return false;
      frame.epoch = held->epoch;
      break;
    case Sabotage::accepts_old_incarnations:
      frame.incarnation = incarnation_;
      break;
    case Sabotage::executes_doubles:
      current_sequence_ = std::max(current_sequence_, frame.sequence_number) + 1;
      frame.sequence_number = current_sequence_;
      break;
    default:
      return false;
  }
  inbox_.receive(frame, {});
  return true;
}

/// Changes the first axis of the image that is in the required state.
void Bench::spoil(service::StatusImage& image) {
  for (std::size_t axis = 0; axis < image.status.size(); ++axis) {
    AxisStatus& status = image.status[axis];
    const PowerState state = decode_power_state(status.ds402_statusword);
    const bool runs = state == PowerState::operation_enabled && status.op_mode_actual == 1;
    const bool rests = state == PowerState::switch_on_disabled;
    switch (sabotage_) {
      case Sabotage::motion_without_power:
        status.velocity_demand_value += rests ? 100 : 0;
        break;
      case Sabotage::push_without_power:
        status.load_velocity_actual_value +=
            rests ? static_cast<std::int32_t>(happenings_.tick() % 512) : 0;
        break;
      case Sabotage::position_jump:
        status.load_position_actual_value += runs ? 5'000 : 0;
        break;
      case Sabotage::speed_beyond_limit:
        status.velocity_demand_value += runs ? 300'000 : 0;
        break;
      case Sabotage::torque_beyond_limit:
        status.torque_demand = runs ? std::int16_t{3'100} : status.torque_demand;
        break;
      case Sabotage::error_code_without_fault:
        status.error_code = rests ? 0x8130 : status.error_code;
        break;
      case Sabotage::wrong_state:
        status.ds402_statusword ^= rests ? Statusword::kReadyToSwitchOn : 0U;
        break;
      case Sabotage::bits_of_another_mode:
        status.ds402_statusword |= rests ? Statusword::kSetPointAcknowledge : 0U;
        break;
      case Sabotage::two_owners:
        image.owners[axis].session += image.owners[axis].session != 0 ? 2 : 0;
        break;
      default:
        break;
    }
  }
}

}  // namespace vdrive::simulation
