// SPDX-License-Identifier: Apache-2.0
#include "engine/bench_engine.hpp"

namespace vdrive::service {

BenchEngine::BenchEngine(const Configuration& configuration, const BenchIdentity& identity,
                         Outbox& outbox, Counters& counters)
    : outbox_(outbox),
      clock_(configuration, counters),
      axes_(configuration),
      events_(clock_, axes_.black_box(), outbox.events, counters),
      frame_answers_(identity, clock_, events_, outbox.command_replies, counters),
      schedule_(frame_answers_, counters),
      writer_(axes_, schedule_),
      brake_(axes_, schedule_, events_),
      masters_(axes_, clock_, schedule_, events_, counters),
      master_watch_(configuration, clock_, masters_, counters),
      application_(axes_, writer_, masters_, frame_answers_, events_, counters),
      frames_(clock_, brake_, masters_, schedule_, frame_answers_, application_, counters),
      axis_events_(axes_, masters_, schedule_, events_, counters),
      output_(identity, clock_, axes_, masters_, events_, outbox, counters),
      request_answers_(identity, clock_, axes_, masters_, events_, outbox.replies, counters),
      stores_(axes_, clock_, masters_, request_answers_, events_, outbox.replies, counters),
      axis_requests_(axes_, writer_, clock_, masters_, schedule_, stores_, events_),
      snapshots_(axes_, clock_, masters_, schedule_, output_, events_, counters),
      windows_(axes_, clock_),
      requests_({clock_, events_, axes_, schedule_, masters_, master_watch_, stores_,
                 axis_requests_, snapshots_, windows_},
                brake_, request_answers_),
      step_requests_(configuration, clock_, frames_, masters_, requests_, request_answers_, events_,
                     counters) {}

bool BenchEngine::can_answer() const noexcept {
  const auto& frames = outbox_.command_replies;
  return outbox_.replies.size() < outbox_.replies.capacity() &&
         frames.capacity() - frames.size() > schedule_.size();
}

void BenchEngine::handle(Arrival& arrival) {
  if (arrival.kind == Arrival::Kind::command_frame) {
    frames_.handle(arrival);
  } else {
    requests_.handle(arrival);
  }
}

void BenchEngine::step() {
  frames_.apply_due();
  if (!brake_.is_engaged()) master_watch_.watch();
  brake_.switch_off_at_rest();
  axes_.step();
  clock_.complete_tick();
  axes_.record_tick(clock_.tick());
  axis_events_.report_changes();
  stores_.answer();
  output_.queue_changes();
}

void BenchEngine::jump(std::uint64_t ticks) {
  clock_.jump(ticks);
  master_watch_.skip(ticks);
  events_.report({.kind = msg::EventKind::tick_jumped, .detail = Count{ticks}});
}

}  // namespace vdrive::service
