// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "seam/queues.hpp"
#include "simulation/happenings.hpp"
#include "simulation/network.hpp"
#include "simulation/store_model.hpp"
#include "support/programs/model.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace vdrive::simulation {

/// Stamps begin here. A command writes its stamp to 6067h, so the parameters of an axis show which
/// command was executed there last.
inline constexpr std::uint32_t kFirstStamp = 1'000'000;

/// Registers of an axis that the actors write.
struct Registers {
  std::uint16_t controlword = 0;
  std::int8_t mode = 0;
  std::int32_t target = 0;
  std::uint32_t stamp = 100;        ///< 6067h, with its default
  std::uint32_t velocity = 68'267;  ///< 6081h, with its default
  std::array<std::int64_t, 11> test_inputs{};

  bool operator==(const Registers&) const = default;

  [[nodiscard]] bool has_test_input() const {
    std::int64_t any = 0;
    for (const std::int64_t value : test_inputs) any |= value;
    return any != 0;
  }
};

/// The owner of each axis, and the fate of each message: an independent model of the promises of
/// docs/reference/wire.md, fed with what arrived. It predicts every answer, owner and register; the
/// messages of the bench are compared with it.
class ControlModel {
 public:
  /// The meaning of a stamp.
  struct Stamped {
    std::uint64_t incarnation = 0;  ///< 0 = any
    std::uint64_t session = 0;
    std::uint32_t epoch = 0;  ///< 0 = written by a request
  };

  /// The tick of the seed in which each epoch was revoked, by incarnation and epoch.
  using Revocations = std::map<std::pair<std::uint64_t, std::uint32_t>, std::uint64_t>;

  /// Stamps of all runs of the service; a stamp is its index plus kFirstStamp.
  void use(const std::vector<Stamped>& stamps, Revocations& revocations) {
    stamps_ = &stamps;
    revocations_ = &revocations;
  }

  ControlModel(const service::Configuration& configuration, std::uint64_t incarnation,
               Happenings& happenings);

  void start_at(std::uint64_t tick) { tick_ = tick; }

  /// The bench has a disk, which contained this set when it started.
  void store_with(StoreModel& stores, const StoredSet& loaded);

  /// The bench took back this number of finished or failed stores.
  void take_back_stores(std::size_t count);

  /// Called when the bench takes the message.
  void arrive(const msg::CommandFrame& frame);
  void arrive(const msg::Request& request);
  void note_message(std::uint64_t session);

  /// Notes a step request, which is not passed to arrive(). @return whether it is a repeat: then
  /// the first answer is due again, unless the step is still in progress.
  bool is_repeat(const msg::Request& request);

  /// @return whether the command frames that were sent before the step have arrived.
  [[nodiscard]] bool has_frames_of(const msg::Request& step);

  /// Expects the answer to a step that was carried out or refused.
  void expect_step_answer(const msg::Request& request, msg::Reason reason);

  void jump(std::uint64_t ticks);

  /// The first half of a tick: frames that are due, masters that fell silent.
  void begin_tick();

  /// The second half: the changes of the axes.
  void end_tick(std::span<const AxisStatus> statuses);

  /// Checks messages that the bench sends.
  void check(const msg::CommandReply& reply);
  void check(const msg::Reply& reply);
  void check(const msg::AxisParameters& parameters);
  void check(const service::EventRecord& event);
  void check_owners(std::span<const wire::Ownership> owners);
  /// Checks that every answer that was due has been checked, and every event.
  void check_all_answered();
  void check_events();

  [[nodiscard]] std::uint64_t tick() const { return tick_; }

  [[nodiscard]] const Registers& registers(std::size_t axis) const { return axes_[axis].registers; }

  [[nodiscard]] const test::AxisCauses& causes(std::size_t axis) const {
    return axes_[axis].causes;
  }

  [[nodiscard]] bool was_restored() const { return restored_; }

  [[nodiscard]] std::uint64_t lost_masters() const { return lost_masters_; }

  [[nodiscard]] std::uint64_t refused_frames() const { return refused_frames_; }

  [[nodiscard]] std::uint64_t commands() const { return commands_; }

 private:
  struct Axis {
    std::uint16_t number = 0;
    std::uint64_t owner = 0;
    std::uint32_t epoch = 0;
    std::uint64_t last_sequence = 0;
    bool was_enabled = false;
    bool is_modulo = false;  ///< 607Bh, as configured: nothing writes it
    Registers registers;
    std::optional<StoredValues> memory;  ///< takes effect at the next power-up
    test::AxisCauses causes;
  };

  struct Session {
    std::uint64_t id = 0;
    std::uint32_t epoch = 0;
    std::uint64_t last_message_tick = 0;
    std::uint64_t last_sequence = 0;
    std::uint64_t last_command = 0;
    bool must_acquire = false;
  };

  /// Numbers of the messages that have arrived from one client or session.
  struct Numbers {
    std::uint64_t highest = 0;
    std::set<std::uint64_t> taken;
    std::set<std::uint64_t> answered;

    void take(std::uint64_t number);
    /// @return whether the number is too old to tell whether it ever arrived.
    [[nodiscard]] bool has_forgotten(std::uint64_t number) const;
  };

  struct Waiting {
    std::uint64_t tick = 0;
    msg::CommandFrame frame;
  };

  struct Refused {
    std::uint16_t axis = 0;
    std::uint16_t index = 0;
    std::uint8_t subindex = 0;
    msg::Reason reason{};

    bool operator==(const Refused&) const = default;
  };

  struct FrameAnswer {
    std::uint64_t session = 0;
    std::uint64_t sequence = 0;
    std::uint64_t tick = 0;
    bool is_wanted = false;
    bool is_repeat = false;  ///< to a repeated frame: the first answer again
    bool is_kept = true;     ///< can be given again
    std::vector<Refused> refusals;
  };

  struct Answer {
    std::uint64_t client = 0;
    std::uint64_t request_id = 0;
    msg::Reason reason{};
    std::uint16_t refused_axis = 0;
    std::uint64_t owner = 0;
    std::uint32_t epoch = 0;
    std::uint64_t last_sequence = 0;
    std::vector<msg::Reason> codes;
    std::vector<std::optional<std::int64_t>> values;
  };

  /// A request that waits for its store orders.
  struct Storing {
    msg::Request request;  ///< its sender and session
    msg::Reason reason{};
    Answer answer;
    std::size_t orders = 0;
  };

  static auto head_of(const Answer& answer) {
    return std::tie(answer.client, answer.request_id, answer.reason, answer.refused_axis,
                    answer.owner, answer.epoch, answer.last_sequence);
  }

  template <typename Kept>
  static void keep(std::deque<Kept>& memory, const Kept& answer);

  static auto sender_of(const FrameAnswer& answer) { return answer.session; }

  static auto sender_of(const Answer& answer) { return answer.client; }

  static std::string words_of(const FrameAnswer& answer);
  static std::string words_of(const Answer& answer);
  static std::string words_of(const Registers& registers);
  void check_stamp(std::uint16_t axis, std::uint32_t stamp);
  void check_objects(const Answer& due, const msg::Reply& reply);
  Axis* axis_of(std::uint16_t number);
  Session* find(std::uint64_t session);
  Session& find_or_add(std::uint64_t session);
  bool owns_any(std::uint64_t session) const;
  void renew(Session& session, bool revoked);
  void lose(Session& session);
  template <typename Condition>
  void drop(Condition condition);
  void drop_of_session(std::uint64_t session);
  void drop_of_axis(std::uint16_t number);
  void expect_event(msg::EventKind kind, std::uint64_t session);

  bool is_repeat(const msg::CommandFrame& frame);
  bool is_waiting(const msg::CommandFrame& frame) const;
  bool is_storing(const msg::Request& request) const;
  const FrameAnswer* kept_of(const FrameAnswer& due) const;
  msg::Reason judge(const msg::CommandFrame& frame);
  msg::Reason judge_time(const msg::CommandFrame& frame) const;
  void refuse(const msg::CommandFrame& frame, msg::Reason reason, bool is_kept = true);
  void apply(const msg::CommandFrame& frame);
  msg::Reason judge_command(const msg::AxisCommand& command, std::uint64_t session,
                            std::set<std::uint16_t>& named);
  bool write_members(const msg::AxisCommand& command, FrameAnswer& answer);
  void write_controlword(const msg::AxisCommand& command, std::uint64_t sequence);
  msg::Reason write(Axis& axis, std::uint16_t number, ObjectAddress address, std::int64_t value);

  msg::Reason carry_out(const msg::Request& request, Answer& answer);
  msg::Reason read_objects(const msg::Request& request, Answer& answer);
  msg::Reason write_objects(const msg::Request& request, Answer& answer);
  msg::Reason write_object(const msg::ObjectAccess& object, std::uint64_t session,
                           std::size_t place);
  void stop(Axis& axis, std::uint16_t number, bool by_halt);
  msg::Reason store_axes(const msg::Request& request, Answer& answer);
  msg::Reason store_by_write(Axis& axis, const msg::ObjectAccess& object, std::size_t place);
  void order(const Axis& axis, bool forget, std::size_t object);
  void power_up(Axis& axis);
  msg::Reason take(const msg::Request& request, bool by_force, Answer& answer);
  msg::Reason release(const msg::Request& request, Answer& answer);
  msg::Reason power_cycle(const msg::Request& request, Answer& answer);
  msg::Reason set_rate(const msg::Request& request);
  msg::Reason snapshot(const msg::Request& request, Answer& answer);
  msg::Reason refuse_strangers(const msg::Request& request, bool by_force, Answer& answer);
  void name_axis(std::uint16_t number, Answer& answer);
  void finish(const msg::Request& request, msg::Reason reason, Answer& answer, bool is_kept = true);
  bool time_stands() const;
  void count_watchdog();

  const service::Configuration& configuration_;
  std::uint64_t incarnation_;
  Happenings& happenings_;
  std::uint64_t tick_ = 0;
  double rate_;
  std::uint64_t watchdog_ = 0;  ///< [ticks], 0 = off
  std::uint32_t last_epoch_ = 0;
  std::vector<Axis> axes_;
  std::vector<Session> sessions_;
  std::deque<Waiting> waiting_;
  std::deque<FrameAnswer> frame_answers_;
  std::deque<Answer> answers_;
  std::map<std::uint64_t, Numbers> frames_;    ///< by session
  std::map<std::uint64_t, Numbers> requests_;  ///< by client
  std::deque<FrameAnswer> kept_frame_answers_;
  std::deque<Answer> kept_answers_;
  std::map<std::uint64_t, Storing> storings_;
  std::uint64_t last_storing_ = 0;
  std::size_t ordered_ = 0;              ///< by the current request
  std::set<std::uint32_t> from_memory_;  ///< stamps with which an axis was powered up
  std::map<std::pair<msg::EventKind, std::uint64_t>, int> events_;  ///< by kind and session
  std::map<std::uint64_t, std::vector<Registers>> snapshots_;
  std::uint64_t last_snapshot_ = 0;
  bool restored_ = false;
  std::uint64_t lost_masters_ = 0;
  std::uint64_t refused_frames_ = 0;
  std::uint64_t commands_ = 0;

  const std::vector<Stamped>* stamps_ = nullptr;
  Revocations* revocations_ = nullptr;
  StoreModel* stores_ = nullptr;  ///< nullptr = nothing can be stored
};

}  // namespace vdrive::simulation
