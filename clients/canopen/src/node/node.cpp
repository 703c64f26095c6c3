// SPDX-License-Identifier: Apache-2.0
#include "node/node.hpp"

#include "node/cob_id.hpp"
#include "node/communication_parameters.hpp"
#include "node/emergency.hpp"
#include "node/heartbeat.hpp"
#include "node/node_dictionary.hpp"
#include "node/pdos.hpp"
#include "node/sdo_server.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <initializer_list>
#include <span>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

constexpr std::uint8_t kNmtSize = 2;
constexpr std::uint8_t kAllNodes = 0;

constexpr ObjectAddress kCommunicationErrorObject{0x1029, 1};

// Values of 1029h:01 (CiA 301, 7.5.2.32); 0 = to pre-operational, only from Operational.
constexpr std::uint32_t kNoChangeOfState = 1;
constexpr std::uint32_t kToStopped = 2;

constexpr std::uint16_t kRecoveredFromBusOff = 0x8140;  // CiA 301, 7.2.7.1

}  // namespace

/// The parts of a node, and its NMT state.
class Node::Parts final : private PdoHost {
 public:
  Parts(const NodeSettings& settings, NodeHost& host, Parameters stored)
      : node_id_(settings.node_id),
        host_(host),
        parameters_(settings.node_id, std::move(stored)),
        pdos_(settings.node_id, *this, settings.sync_period),
        emergency_(settings.node_id, host),
        producer_(settings.node_id, host),
        dictionary_(settings, {parameters_, pdos_, emergency_, producer_, consumer_}, host, drive_),
        sdo_(settings.node_id, host, dictionary_) {
    ensure(node_id_ >= kLowestNodeId && node_id_ <= kHighestNodeId, "a node id is 1 to 127");
  }

  void start(const DriveView& drive, DriveTime now);
  void receive(const Frame& frame, DriveTime now);
  void update(const DriveView& drive, DriveTime now);
  void advance(DriveTime now);
  void set_bus_off(bool is_off, DriveTime now);
  void complete(std::uint32_t ticket, const DriveAnswer& answer, DriveTime now);

  [[nodiscard]] std::optional<DriveTime> next_due() const;

  [[nodiscard]] std::vector<ObjectAddress> read_objects() const { return pdos_.read_objects(); }

  void set_values(std::span<const DriveValue> values) {
    for (const DriveValue& value : values) pdos_.set_value(value);
  }

  void note_refused_set_points(std::uint64_t count) noexcept {
    counters_.refused_set_points += count;
  }

  [[nodiscard]] std::uint8_t id() const noexcept { return node_id_; }

  [[nodiscard]] NmtState state() const noexcept { return state_; }

  [[nodiscard]] const NodeCounters& counters() noexcept;

  [[nodiscard]] const Parameters& stored() const noexcept { return parameters_.stored(); }

  [[nodiscard]] std::optional<std::int64_t> value(ObjectAddress object) const;

  [[nodiscard]] std::uint64_t parameter_changes() const noexcept {
    return resets_ + dictionary_.writes();
  }

 private:
  void send(const Frame& frame) override { host_.send(frame); }

  void command(std::span<const DriveValue> values, std::uint8_t pdos) override;

  void raise(std::uint16_t error_code) override { emergency_.begin_error(error_code, now_); }

  void receive_nmt(const Frame& frame);
  void receive_request(const Frame& frame);
  void receive_heartbeat(const Frame& frame);
  void start_remote_node();
  void reset_communication();
  void enter(NmtState next);
  void watch_producers();
  void end_errors();
  void end_heartbeat_error();
  void react_to_communication_error();
  void answered();
  void lose_master();
  void regain_master();
  void leave_by_nmt();

  std::uint8_t node_id_;
  NodeHost& host_;
  NodeCounters counters_;
  std::uint64_t resets_ = 0;  ///< of all communication parameters together
  NmtState state_ = NmtState::boot_up;
  DriveTime now_{};   ///< of the current call
  DriveView drive_;   ///< after its last tick
  AxisStatus shown_;  ///< the same, as masters see it

  CommunicationParameters parameters_;
  Pdos pdos_;
  Emergency emergency_;
  HeartbeatProducer producer_;
  HeartbeatConsumer consumer_;
  NodeDictionary dictionary_;
  SdoServer sdo_;

  bool is_led_ = false;  ///< a master has started the node, and has not stopped or reset it since
                         ///< by NMT
  bool has_heartbeat_error_ = false;
  bool is_without_master_ = false;  ///< the last value passed to NodeHost::set_connection_lost()
  bool has_left_by_nmt_ = false;    ///< the master was lost by an NMT command: only an NMT start
                                    ///< ends the loss
};

void Node::Parts::start(const DriveView& drive, DriveTime now) {
  now_ = now;
  is_led_ = false;
  regain_master();  // resets 5E0Ah for the next loss, if the drive is still the same
  dictionary_.forget_access();
  sdo_.reset();
  emergency_.forget_restart();
  drive_ = drive;
  shown_ = drive.status;
  reset_communication();
  update(drive, now);
}

/// NMT and error control act in every state, SDO in all but Stopped, PDOs in Operational only (CiA
/// 301, 7.3.2.2.5). Pdos learns the state by start() and stop().
void Node::Parts::receive(const Frame& frame, DriveTime now) {
  if (state_ == NmtState::boot_up || frame.is_extended) return;
  now_ = now;
  if (frame.id == kNmtId) {
    receive_nmt(frame);
  } else if (frame.id == kSdoRequestId + node_id_) {
    receive_request(frame);
  } else if (frame.id > kHeartbeatId && frame.id <= kHeartbeatId + kHighestNodeId) {
    receive_heartbeat(frame);
  } else {
    pdos_.receive(frame, now);
  }
  end_errors();
}

/// Called wherever a PDO or SYNC error can end: after a correct frame, a changed parameter or a
/// change of the NMT state.
void Node::Parts::end_errors() {
  if (!pdos_.has_error()) emergency_.end_errors(now_);
}

void Node::Parts::receive_nmt(const Frame& frame) {
  if (frame.is_remote || frame.size != kNmtSize) {
    ++counters_.ignored_frames;
    return;
  }
  if (frame.data[1] != kAllNodes && frame.data[1] != node_id_) return;
  switch (static_cast<NmtService>(frame.data[0])) {
    case NmtService::start:
      return start_remote_node();
    case NmtService::stop:
      leave_by_nmt();
      return enter(NmtState::stopped);
    case NmtService::enter_pre_operational:
      return enter(NmtState::pre_operational);
    case NmtService::reset_node:
      leave_by_nmt();
      host_.power_cycle();
      reset_communication();
      return emergency_.await_restart(drive_.status, now_);
    case NmtService::reset_communication:
      leave_by_nmt();
      return reset_communication();
    default:
      ++counters_.ignored_frames;
  }
}

void Node::Parts::start_remote_node() {
  is_led_ = true;
  regain_master();
  enter(NmtState::operational);
}

/// Goes from any state through initialisation to pre-operational, with the stored parameters.
void Node::Parts::reset_communication() {
  state_ = NmtState::boot_up;
  ++resets_;
  pdos_.stop();
  sdo_.stop();
  pdos_.reset();
  emergency_.reset();
  producer_.reset();
  consumer_.reset();
  parameters_.reset();
  dictionary_.forget_date();
  has_heartbeat_error_ = false;
  if (!has_left_by_nmt_) regain_master();
  parameters_.restore([this](ObjectAddress object, std::uint32_t value) {
    return dictionary_.write(object, value, now_);
  });
  producer_.boot_up(now_);
  enter(NmtState::pre_operational);
}

void Node::Parts::enter(NmtState next) {
  if (next == state_) return;
  if (state_ == NmtState::operational) pdos_.stop();
  if (next == NmtState::stopped) sdo_.stop();
  state_ = next;
  emergency_.set_allowed(next != NmtState::stopped, now_);
  if (next == NmtState::operational) pdos_.start(shown_, now_);
}

/// SDO frames always have 8 bytes (CiA 301, 7.2.4.3). Others are not answered, as masters expect
/// from real nodes: the missing bytes may hold the object that an abort would have to name.
void Node::Parts::receive_request(const Frame& frame) {
  if (frame.is_remote || frame.size != kMostData) {
    ++counters_.ignored_frames;
    return;
  }
  if (state_ == NmtState::stopped) return;
  sdo_.receive(frame, now_);
  answered();
}

void Node::Parts::complete(std::uint32_t ticket, const DriveAnswer& answer, DriveTime now) {
  now_ = now;
  const auto answer_to_client = dictionary_.complete(ticket, answer);
  if (!answer_to_client) return;
  sdo_.finish(*answer_to_client, now);
  answered();
}

/// Called after the response to the client: carries out the immediate effects of a written
/// parameter.
void Node::Parts::answered() {
  producer_.advance(state_, now_);  // 1017h: the first heartbeat
  end_heartbeat_error();            // 1016h: the silent producer is no longer monitored
  end_errors();                     // the parameters of a PDO may have changed
}

/// A remote frame would be node guarding, which is not supported: it is not answered.
void Node::Parts::receive_heartbeat(const Frame& frame) {
  const auto producer = static_cast<std::uint8_t>(frame.id - kHeartbeatId);
  if (producer == node_id_ || frame.is_remote || frame.size != 1) return;
  consumer_.receive(producer, now_);
  end_heartbeat_error();
}

/// Raises the emergencies for silent producers first: 1029h may lead to Stopped, where none are
/// sent.
void Node::Parts::watch_producers() {
  bool is_new = false;
  while (const auto producer = consumer_.take_silent(now_)) {
    emergency_.begin_heartbeat_error(*producer, now_);
    is_new = true;
  }
  if (!is_new) return;
  has_heartbeat_error_ = true;
  lose_master();
  react_to_communication_error();
}

void Node::Parts::react_to_communication_error() {
  const std::uint32_t behaviour = parameters_.value(kCommunicationErrorObject);
  if (behaviour == kToStopped) {
    enter(NmtState::stopped);
  } else if (behaviour != kNoChangeOfState && state_ == NmtState::operational) {
    enter(NmtState::pre_operational);
  }
}

/// Bus-off is a communication error like a lost heartbeat (CiA 301, 7.5.2.32).
void Node::Parts::set_bus_off(bool is_off, DriveTime now) {
  if (state_ == NmtState::boot_up) return;
  now_ = now;
  if (is_off) {
    lose_master();
    react_to_communication_error();
    return;
  }
  raise(kRecoveredFromBusOff);
  end_errors();  // 8140h is over as soon as it is reported
  if (!has_heartbeat_error_ && !has_left_by_nmt_) regain_master();
}

void Node::Parts::end_heartbeat_error() {
  if (!has_heartbeat_error_ || consumer_.has_silent()) return;
  has_heartbeat_error_ = false;
  emergency_.end_heartbeat_error(now_);
  if (!has_left_by_nmt_) regain_master();
}

/// Reports the loss even if the node already has no master: another one may have enabled the drive
/// by SDO since.
void Node::Parts::lose_master() {
  is_without_master_ = true;
  host_.set_connection_lost(true);
}

void Node::Parts::regain_master() {
  has_left_by_nmt_ = false;
  if (!is_without_master_) return;
  is_without_master_ = false;
  host_.set_connection_lost(false);
}

/// The drive also reacts per 6007h at NMT stop, reset communication and reset node. A node that no
/// master has started has none to lose: masters reset all nodes before they configure them.
void Node::Parts::leave_by_nmt() {
  if (!is_led_) return;
  is_led_ = false;
  has_left_by_nmt_ = true;
  lose_master();
}

void Node::Parts::command(std::span<const DriveValue> values, std::uint8_t pdos) {
  if (drive_.is_owned) {
    host_.command(values);
  } else {
    counters_.ignored_set_points += pdos;
  }
}

void Node::Parts::update(const DriveView& drive, DriveTime now) {
  if (state_ == NmtState::boot_up) return;
  now_ = now;
  drive_ = drive;
  shown_ = drive.status;
  if (!drive.is_owned) {
    shown_.ds402_statusword =
        static_cast<std::uint16_t>(shown_.ds402_statusword & ~unsigned{Statusword::kRemote});
  }
  emergency_.update(shown_, now);
  shown_.error_register =
      static_cast<std::uint8_t>(shown_.error_register | emergency_.error_register());
  pdos_.update(shown_, now);
}

void Node::Parts::advance(DriveTime now) {
  if (state_ == NmtState::boot_up) return;
  now_ = now;
  watch_producers();
  producer_.advance(state_, now);
  sdo_.advance(now);
  emergency_.advance(now);
  pdos_.advance(now);
  end_errors();  // 1029h may have ended Operational, and with it the errors of PDOs
}

std::optional<DriveTime> Node::Parts::next_due() const {
  if (state_ == NmtState::boot_up) return std::nullopt;
  std::optional<DriveTime> first;
  for (const std::optional<DriveTime>& due :
       {consumer_.next_due(), producer_.next_due(), sdo_.next_due(), emergency_.next_due(),
        pdos_.next_due()}) {
    if (due && (!first || *due < *first)) first = due;
  }
  return first;
}

const NodeCounters& Node::Parts::counters() noexcept {
  counters_.dropped_pdos = pdos_.counters().dropped;
  counters_.sdo_aborts = sdo_.counters().aborts;
  counters_.sdo_time_outs = sdo_.counters().time_outs;
  counters_.held_back_emergencies = emergency_.held_back();
  return counters_;
}

std::optional<std::int64_t> Node::Parts::value(ObjectAddress object) const {
  return dictionary_.value(object);
}

Node::Node(const NodeSettings& settings, NodeHost& host, Parameters stored)
    : parts_(std::make_unique<Parts>(settings, host, std::move(stored))) {}

Node::~Node() = default;
Node::Node(Node&&) noexcept = default;
Node& Node::operator=(Node&&) noexcept = default;

void Node::start(const DriveView& drive, DriveTime now) {
  parts_->start(drive, now);
}

void Node::receive(const Frame& frame, DriveTime now) {
  parts_->receive(frame, now);
}

void Node::update(const DriveView& drive, DriveTime now) {
  parts_->update(drive, now);
}

void Node::advance(DriveTime now) {
  parts_->advance(now);
}

void Node::set_bus_off(bool is_off, DriveTime now) {
  parts_->set_bus_off(is_off, now);
}

std::optional<DriveTime> Node::next_due() const {
  return parts_->next_due();
}

void Node::complete(std::uint32_t ticket, const DriveAnswer& answer, DriveTime now) {
  parts_->complete(ticket, answer, now);
}

std::vector<ObjectAddress> Node::read_objects() const {
  return parts_->read_objects();
}

void Node::set_values(std::span<const DriveValue> values) {
  parts_->set_values(values);
}

void Node::note_refused_set_points(std::uint64_t count) noexcept {
  parts_->note_refused_set_points(count);
}

std::uint8_t Node::id() const noexcept {
  return parts_->id();
}

NmtState Node::state() const noexcept {
  return parts_->state();
}

const NodeCounters& Node::counters() const noexcept {
  return parts_->counters();
}

const Node::Parameters& Node::stored() const noexcept {
  return parts_->stored();
}

std::uint64_t Node::parameter_changes() const noexcept {
  return parts_->parameter_changes();
}

std::optional<std::int64_t> Node::value(ObjectAddress object) const {
  return parts_->value(object);
}

}  // namespace vdrive::canopen
