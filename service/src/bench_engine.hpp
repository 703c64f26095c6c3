// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "answer_memory.hpp"
#include "configuration.hpp"
#include "control_table.hpp"
#include "counters.hpp"
#include "journal.hpp"
#include "parameter_saver.hpp"
#include "pending_frames.hpp"
#include "queues.hpp"
#include "step_pool.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive_messages.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace vdrive::service {

/// Identity of one run of a bench on the network.
struct BenchIdentity {
  std::uint32_t bench = 0;
  std::uint64_t incarnation = 0;  ///< start of the service [ns since the epoch]
};

/// Codes of EVENT_SNAPSHOT.
struct SnapshotNews {
  static constexpr std::uint32_t kTaken = 1;
  static constexpr std::uint32_t kRestored = 2;
  static constexpr std::uint32_t kDropped = 3;
};

/// How a bench that ends brings its enabled axes to rest.
enum class Braking : std::uint8_t {
  ramp,        ///< Disable operation: the ramp of 605Ch
  quick_stop,  ///< the ramp of 605Ah
  none,        ///< Disable voltage: they coast
};

/// The bench without clock and network: takes what arrived, decides who may do what, steps the
/// bank, and puts answers, events and images into the outbox. Belongs to one thread. Once warm it
/// allocates nothing and takes no lock.
class BenchEngine {
 public:
  /// How far ahead a frame may be sent.
  static constexpr std::chrono::seconds kFurthestAhead{10};
  static constexpr std::uint64_t kMaxTicksPerStep = 1'000'000;
  static constexpr std::size_t kMostSnapshots = 16;

  /// The last completed tick is 0 until `start_at`.
  /// @throws std::invalid_argument when the bank refuses the axes
  BenchEngine(const Configuration& configuration, const BenchIdentity& identity, Outbox& outbox,
              Counters& counters);

  /// Before the first step: the first tick is the one after `last_tick`.
  void start_at(std::uint64_t last_tick);

  /// Before the first arrival: records into `journal`, which outlives this engine.
  /// @throws std::system_error when the journal cannot be begun
  void record_to(Journal& journal);

  /// Before the first arrival: stores parameters with `saver`, which outlives this engine. Without
  /// one nothing can be stored.
  void store_with(ParameterSaver& saver);

  /// Last completed tick.
  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }

  [[nodiscard]] const AxisBank& bank() const noexcept { return bank_; }

  /// Realtime: drive time over wall time, 0 = paused. Requests change it. 0 in other clock modes.
  [[nodiscard]] double rate() const noexcept { return rate_; }

  /// @return whether there is room for the answer to one more arrival and to every frame that
  ///         waits, which one request may drop.
  [[nodiscard]] bool can_answer() const noexcept;

  /// Carries a command frame or a request out, or refuses it. Steps and who may step are refused:
  /// the lock-step driver keeps those requests for itself.
  void handle(Arrival& arrival);

  /// One tick.
  void step();

  /// Puts the status image of the last tick into the outbox.
  /// @param repeated the image was shown before; it is sent again for clients that joined later
  void post_status(bool repeated = false);

  /// Moves as many changed parameter sets as fit into the outbox and reports full queues; also part
  /// of every step.
  void post_parameters();

  /// Gives the axes the parameters that have become durable and answers the requests that wait for
  /// them; also part of every step.
  /// @return whether there was anything.
  bool answer_stores();

  /// The tick number jumps forward and the state is held; the jump does not count as silence of a
  /// master.
  void jump(std::uint64_t ticks);

  /// A tick took longer than its period.
  void report_overrun(std::chrono::nanoseconds late);

  /// Puts what happened into the outbox, with the present tick.
  void report(EventRecord event);

  /// Notes a request that `handle` does not get. @return whether it has arrived before. Such a
  /// request is answered again, unless it is in progress, and needs no further work.
  [[nodiscard]] bool is_repeat(const Arrival& arrival);

  /// Checks a request about the steps of a lock-step bench. @return REASON_NONE or why it is
  /// refused.
  [[nodiscard]] std::uint32_t check_step(const Arrival& arrival) const;

  /// @return whether the command frame `sequence` of `session` has arrived.
  [[nodiscard]] bool has_arrived(std::uint64_t session, std::uint64_t sequence);

  /// The bench ends: from the first call on only reads are answered, masters need not be heard, and
  /// every step switches off what has come to rest. Writes the controlwords that brake the axes
  /// that are still enabled; may be called again to brake harder.
  void shut_down(Braking braking);

  /// @return whether an axis is in any other state than Not ready to switch on, Switch on disabled
  ///         and Fault.
  [[nodiscard]] bool has_power() const noexcept;

  /// @return whether no tick comes by itself: lock-step, or paused.
  [[nodiscard]] bool time_stands() const noexcept;

  /// A message of the session arrived now.
  void hear(std::uint64_t session);

  /// Answers a checked request of that kind, with the status of the axes that it names when
  /// `reason` is REASON_NONE or REASON_MISSING_STEPPER.
  /// @param missing_stepper the session whose grant is missing
  void answer_step(const Arrival& arrival, std::uint32_t reason, std::uint64_t missing_stepper = 0);

 private:
  /// What was last seen of an axis, to notice changes.
  struct Seen {
    std::uint16_t statusword = 0;
    std::uint16_t error_code = 0;
    std::uint32_t ignored_set_points = 0;
    std::uint32_t fault_count = 0;
  };

  /// A register before it was overwritten by a frame that may have to be taken back.
  struct Undo {
    std::uint16_t axis = 0;
    ObjectAddress address;
    std::int64_t value = 0;
  };

  // frames: bench_frames.cpp
  void handle_frame(Arrival& arrival);
  [[nodiscard]] std::uint32_t check_sender(const msg::CommandFrame& frame);
  [[nodiscard]] bool is_repeat(const msg::CommandFrame& frame);
  [[nodiscard]] std::uint32_t check_frame(const Arrival& arrival, SessionRecord& record);
  [[nodiscard]] std::uint32_t check_time(const msg::CommandFrame& frame) const;
  void apply_due_frames();
  void apply_frame(const msg::CommandFrame& frame);
  [[nodiscard]] std::uint32_t check_command(const msg::AxisCommand& command, std::uint64_t session);
  void apply_each(const msg::CommandFrame& frame);
  void apply_all_or_nothing(const msg::CommandFrame& frame);
  bool apply_registers(const msg::AxisCommand& command, bool undoable);
  bool apply_register(std::uint16_t number, ObjectAddress address, std::int64_t value,
                      bool undoable);
  void apply_controlword(const msg::AxisCommand& command, std::uint64_t sequence);
  void refuse(std::uint16_t axis, ObjectAddress address, std::uint32_t reason);
  void refuse_frame(const msg::CommandFrame& frame, std::uint32_t reason);
  [[nodiscard]] std::uint64_t lateness(const msg::CommandFrame& frame) const noexcept;
  void send_reply(const msg::CommandFrame& frame, msg::CommandReply& reply);
  void post(const msg::CommandReply& reply);
  void drop_pending_of_session(std::uint64_t session);
  void drop_pending_of_axis(std::uint16_t axis);

  // requests: bench_requests.cpp
  void handle_request(const Arrival& arrival);
  [[nodiscard]] std::uint32_t check_request(const Arrival& arrival) const;
  [[nodiscard]] std::uint32_t carry_out(const msg::Request& request, msg::Reply& reply);
  void begin_reply(const Arrival& arrival, OutgoingReply& outgoing) const;
  void finish_reply(std::uint64_t session, std::uint32_t reason, msg::Reply& reply);
  void keep(msg::Reply& reply);
  void answer_again(const Arrival& arrival);
  [[nodiscard]] bool is_of_this_run(const msg::Request& request) const noexcept;
  [[nodiscard]] bool knows_axes(const msg::Request& request) const;
  [[nodiscard]] std::uint32_t read_objects(const msg::Request& request, msg::Reply& reply);
  [[nodiscard]] std::uint32_t write_objects(const msg::Request& request, msg::Reply& reply);
  [[nodiscard]] std::uint32_t write_object(const msg::ObjectAccess& object, std::uint64_t session,
                                           std::size_t place);
  [[nodiscard]] std::uint32_t write_command_object(std::size_t axis, ObjectAddress address,
                                                   std::int64_t value, std::uint64_t session);
  [[nodiscard]] std::uint32_t acquire(const msg::Request& request, bool by_force,
                                      msg::Reply& reply);
  [[nodiscard]] std::uint32_t release(const msg::Request& request, msg::Reply& reply);
  void free_axes(const msg::Request& request);
  [[nodiscard]] std::uint32_t power_cycle(const msg::Request& request, msg::Reply& reply);
  [[nodiscard]] std::uint32_t check_axes(const msg::Request& request, bool owned_by_others_allowed,
                                         msg::Reply& reply) const;
  void refuse_axis(std::uint16_t number, msg::Reply& reply) const;
  void lose_axis(std::size_t axis);
  [[nodiscard]] std::uint32_t set_rate(const msg::Request& request);
  void add_statuses(const msg::Request& request, msg::Reply& reply) const;

  // snapshots: bench_snapshots.cpp
  struct KeptSnapshot {
    std::uint64_t number = 0;
    std::shared_ptr<const AxisBank::Snapshot> state;
  };

  [[nodiscard]] std::uint32_t take_snapshot(const msg::Request& request, msg::Reply& reply);
  [[nodiscard]] std::uint32_t restore_snapshot(const msg::Request& request, msg::Reply& reply);
  [[nodiscard]] std::uint32_t drop_snapshot(const msg::Request& request);
  void tell_snapshot(const msg::Request& request, std::uint32_t code, std::uint64_t number);

  // the end: bench_shutdown.cpp
  void stop_axis(std::size_t axis);
  void switch_off_at_rest(std::size_t axis);
  [[nodiscard]] bool stands(std::size_t axis) const noexcept;

  // parameters: bench_parameters.cpp
  /// A request that waits until what it stores is durable.
  struct WaitingStore {
    OutgoingReply outgoing;
    std::uint64_t session = 0;
    std::uint32_t reason = 0;  ///< of what has come back
    std::size_t orders = 0;    ///< on their way; 0 = the place is free
  };

  static constexpr std::size_t kMostWaitingStores = 1'024;
  static constexpr std::size_t kOrdersPerTick = 4;

  [[nodiscard]] std::uint32_t store_axes(const msg::Request& request, msg::Reply& reply);
  [[nodiscard]] std::uint32_t store_by_write(std::size_t axis, ObjectAddress address,
                                             std::int64_t value, std::size_t object);
  void order(std::size_t axis, bool forget, std::size_t object);
  void wait_for_orders(std::uint64_t session, std::uint32_t reason, OutgoingReply& outgoing);
  void take_order(const StoreOrder& order, WaitingStore& waiting);
  void keep_in_bank(const StoreOrder& order);
  [[nodiscard]] bool is_storing(const msg::Request& request) const;

  // shared
  [[nodiscard]] std::optional<std::size_t> index_of(std::uint16_t number) const noexcept;
  AbortCode write(std::size_t axis, ObjectAddress address, std::int64_t value);
  void stretch_watchdog();
  void watch_masters();
  void lose_master(SessionRecord& record);
  void to_journal(const JournalChange& change);
  void tell_journal();
  void observe();
  void observe_state(std::size_t axis, const AxisStatus& status, Seen& seen);
  void mark_changed(std::size_t axis);
  void tell_overflows();

  BenchIdentity identity_;
  ClockMode clock_;
  std::chrono::microseconds period_;
  std::optional<std::chrono::milliseconds> watchdog_;  ///< at a rate of 1 or below
  double rate_;
  std::uint64_t tick_ = 0;
  std::uint64_t watchdog_ticks_ = 0;  ///< 0 = off
  std::uint64_t furthest_ahead_ = 0;  ///< [ticks]
  Outbox& outbox_;
  Counters& counters_;
  AxisBank bank_;
  StepPool pool_;
  ControlTable control_;
  AnswerMemory<msg::Reply> requests_;         ///< by client and request id
  AnswerMemory<msg::CommandReply> commands_;  ///< by session and sequence number
  std::vector<msg::AxisStatus> statuses_;     ///< empty: takes the place of what is not kept
  PendingFrames pending_;
  std::vector<std::uint16_t> numbers_;  ///< of the axes, by index
  std::vector<std::uint16_t> indices_;  ///< of the numbers; kMaxAxes = none
  std::vector<Seen> seen_;
  std::vector<std::uint32_t> named_in_;  ///< by index: the last frame that named the axis
  std::uint32_t frame_count_ = 0;
  msg::CommandFrame due_frame_;
  msg::CommandReply command_reply_;  ///< of the frame that is being applied
  msg::CommandReply frame_refusal_;  ///< of a frame that is refused as a whole
  std::vector<bool> skipped_;        ///< commands of the frame that is being applied
  std::vector<Undo> undo_;
  std::vector<std::uint16_t> changed_axes_;  ///< circular queue of axes with changed parameters
  std::size_t first_changed_ = 0;
  std::size_t changed_count_ = 0;
  std::vector<bool> is_changed_;
  std::uint64_t told_overflows_ = 0;
  std::vector<KeptSnapshot> snapshots_;  ///< by number
  std::uint64_t last_snapshot_ = 0;
  Journal* journal_ = nullptr;
  std::optional<Braking> braking_;  ///< the bench ends
  ParameterSaver* saver_ = nullptr;
  std::vector<WaitingStore> waiting_stores_;
  std::vector<std::uint32_t> free_places_;  ///< in waiting_stores_
  std::size_t ordered_ = 0;                 ///< by the request in hand
};

}  // namespace vdrive::service
