// SPDX-License-Identifier: Apache-2.0
#include "bridge/bench_nodes.hpp"

#include "node/cob_id.hpp"
#include "node/node_object.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::canopen {
namespace {

constexpr ObjectAddress kCobIdOfSync{0x1005, 0};
constexpr ObjectAddress kSyncCounterOverflow{0x1019, 0};
constexpr std::uint16_t kReceivePdos = 0x1400;        // four of them
constexpr std::uint16_t kHeartbeatConsumer = 0x1016;  // four entries
constexpr std::uint8_t kEntries = 4;

/// @param cob_id of a SYNC or a PDO, which may be disabled (bit 31)
void add_identifier(std::optional<std::int64_t> cob_id, std::vector<std::uint16_t>& identifiers) {
  constexpr std::int64_t kIsOff = 0x80000000;
  if (!cob_id || (*cob_id & kIsOff) != 0) return;
  identifiers.push_back(static_cast<std::uint16_t>(*cob_id & kHighestBaseId));
}

/// @param entry of 1016h: node id in bits 16 to 22, time in bits 0 to 15
void add_producer(std::optional<std::int64_t> entry, std::vector<std::uint16_t>& identifiers) {
  if (!entry || (*entry & 0xFFFF) == 0) return;
  add_identifier(std::int64_t{kHeartbeatId} + ((*entry >> 16) & 0x7F), identifiers);
}

/// The identifiers that a node listens to, besides its SDO requests and frames for all nodes.
void collect_identifiers(const Node& node, std::vector<std::uint16_t>& identifiers) {
  identifiers.clear();
  add_identifier(node.value(kCobIdOfSync), identifiers);
  for (std::uint8_t entry = 0; entry < kEntries; ++entry) {
    const auto pdo = static_cast<std::uint16_t>(kReceivePdos + entry);
    add_identifier(node.value({pdo, 1}), identifiers);
    const auto subindex = static_cast<std::uint8_t>(entry + 1);
    add_producer(node.value({kHeartbeatConsumer, subindex}), identifiers);
  }
}

/// Simulates a second device that has the id of a node by mistake: it boots, also answers each SDO
/// request, and obeys NMT and SYNC. Its drive never changes: each object has its default, and
/// writing has no effect.
class DuplicateNode final : private NodeHost {
 public:
  using Send = std::function<void(const Frame& frame)>;

  /// Boots the device.
  /// @param settings its texts are copied
  DuplicateNode(const NodeSettings& settings, Send send, DriveTime now)
      : send_(std::move(send)), node_(settings, *this) {
    constexpr std::uint16_t kSwitchOnDisabled = 0x0240;  // 6041h, with the remote bit
    DriveView at_rest;
    at_rest.status.ds402_statusword = kSwitchOnDisabled;
    node_.start(at_rest, now);
  }

  void receive(const Frame& frame, DriveTime now) {
    node_.receive(frame, now);
    while (access_) {
      const DriveAccess access = *std::exchange(access_, std::nullopt);
      node_.complete(access.ticket, {.value = initial_value(access.object)}, now);
    }
  }

  void advance(DriveTime now) {
    const auto due = node_.next_due();
    if (due && *due <= now) node_.advance(now);
  }

 private:
  void send(const Frame& frame) override { send_(frame); }

  void begin_access(const DriveAccess& access) override { access_ = access; }

  void command(std::span<const DriveValue> /*values*/) override {}

  void set_connection_lost(bool /*is_lost*/) override {}

  void power_cycle() override {}

  bool store(const Node::Parameters& /*parameters*/) override { return true; }

  const Send send_;
  std::optional<DriveAccess> access_;  ///< unanswered
  Node node_;
};

}  // namespace

void add_counters(NodeCounters& sum, const NodeCounters& more) {
  sum.ignored_set_points += more.ignored_set_points;
  sum.refused_set_points += more.refused_set_points;
  sum.dropped_pdos += more.dropped_pdos;
  sum.sdo_aborts += more.sdo_aborts;
  sum.sdo_time_outs += more.sdo_time_outs;
  sum.ignored_frames += more.ignored_frames;
  sum.held_back_emergencies += more.held_back_emergencies;
}

/// A node, and the actions it asks for, which are carried out once its call has returned.
class BenchNodes::Slot final : public NodeHost {
 public:
  Slot(BenchNodes& nodes, std::size_t place, const NodePlace& ids)
      : nodes_(nodes), place_(place), ids_(ids) {}

  [[nodiscard]] const NodePlace& ids() const noexcept { return ids_; }

  [[nodiscard]] Node* node() noexcept { return node_ ? &*node_ : nullptr; }

  /// @return whether identifiers() may have changed since it was last called.
  [[nodiscard]] bool has_new_parameters() const {
    return node_ && node_->parameter_changes() != known_changes_;
  }

  [[nodiscard]] std::span<const std::uint16_t> identifiers() {
    if (has_new_parameters()) collect_identifiers(*node_, identifiers_);
    known_changes_ = node_->parameter_changes();
    return identifiers_;
  }

  void start(const client::AxisSnapshot& drive) {
    node_.emplace(settings(), *this, nodes_.store_.find(ids_.node_id));
    known_changes_.reset();
    asked_changes_.reset();
    is_asked_ = false;
    is_loss_untold_ = false;
    is_bus_off_ = false;
    duplicate_.reset();
    node_->start(view_of(drive), nodes_.now_);
  }

  void stop() {
    if (!node_) return;
    add_counters(nodes_.ended_, node_->counters());
    node_.reset();
    duplicate_.reset();
    accessed_.reset();
  }

  void update(const client::AxisSnapshot& drive) {
    node_->update(view_of(drive), nodes_.now_);
    if (is_owned_ && std::exchange(is_loss_untold_, false)) set_connection_lost(true);
    const auto due = node_->next_due();
    if (due && *due <= nodes_.now_) node_->advance(nodes_.now_);
  }

  void complete(std::uint32_t ticket, const DriveAnswer& answer) {
    if (!node_ || !accessed_ || ticket != last_ticket_) return;
    // Before complete(), in which the node may begin its next access.
    const DriveAccess access = *std::exchange(accessed_, std::nullopt);
    node_->complete(access.ticket, answer, nodes_.now_);
  }

  // ---- faults of the bus

  [[nodiscard]] DuplicateNode* duplicate() noexcept { return duplicate_.get(); }

  void follow_faults() {
    const auto acts = [this](BusFaultKind kind) {
      return nodes_.bus_.faults().acts(kind, ids_.node_id, nodes_.fault_time());
    };
    const bool is_off = acts(BusFaultKind::bus_off);
    if (std::exchange(is_bus_off_, is_off) != is_off) node_->set_bus_off(is_off, nodes_.now_);
    if (!acts(BusFaultKind::duplicate)) {
      duplicate_.reset();
    } else if (!duplicate_) {
      const auto send_frame = [this](const Frame& frame) {
        send(frame);
      };
      duplicate_ = std::make_unique<DuplicateNode>(settings(), send_frame, nodes_.now_);
    } else {
      duplicate_->advance(nodes_.now_);
    }
  }

  // ---- values that are not in the status

  /// Requests the objects of the node's TPDOs if they may have changed since the last request.
  void ask_for_new_values() {
    if (!node_ || is_asked_ || asked_changes_ == node_->parameter_changes()) return;
    asked_changes_ = node_->parameter_changes();
    read_objects_ = node_->read_objects();
    ask();
  }

  /// Sends a request if one is due and the drive has a new tick.
  void ask_for_values() {
    ask_for_new_values();
    if (is_asked_ || read_objects_.empty() || !node_) return;
    const bool is_new_tick = nodes_.now_ != asked_at_;
    if (is_new_tick && nodes_.now_ - asked_at_ >= nodes_.options_.read_period) ask();
  }

  void take_values(std::uint32_t ticket, std::span<const DriveValue> values) {
    if (!node_ || !is_asked_ || ticket != read_ticket_) return;
    is_asked_ = false;
    node_->set_values(values);
  }

  // ---- actions of the node

  void send(const Frame& frame) override {
    nodes_.outgoing_.push_back({.frame = frame, .place = place_});
  }

  void begin_access(const DriveAccess& access) override {
    accessed_ = access;
    // Not the node's ticket: each new node counts from 1, and the answer to an access of the
    // previous node may still arrive.
    ++last_ticket_;
    DriveAccess asked = access;
    asked.ticket = last_ticket_;
    nodes_.drive_calls_.emplace_back([&drives = nodes_.drives_, place = place_, asked] {
      drives.access(place, asked);
    });
  }

  void command(std::span<const DriveValue> values) override {
    nodes_.set_points_.add(ids_.axis, values);
  }

  void set_connection_lost(bool is_lost) override {
    // An axis that another session controls does not lose its master now. The loss is reported if
    // the node still has no master when control is back.
    is_loss_untold_ = is_lost && !is_owned_;
    if (is_loss_untold_) return;
    nodes_.drive_calls_.emplace_back([&drives = nodes_.drives_, place = place_, is_lost] {
      drives.tell_connection(place, is_lost);
    });
  }

  void power_cycle() override {
    nodes_.drive_calls_.emplace_back([&drives = nodes_.drives_, place = place_] {
      drives.cycle_power(place);
    });
  }

  bool store(const Node::Parameters& parameters) override {
    return nodes_.store_.save(ids_.node_id, parameters);
  }

 private:
  void ask() {
    if (read_objects_.empty()) return;
    is_asked_ = true;
    asked_at_ = nodes_.now_;
    ++read_ticket_;
    nodes_.drives_.read(place_, read_ticket_, read_objects_);
  }

  [[nodiscard]] NodeSettings settings() const {
    return {.node_id = ids_.node_id,
            .software_version = nodes_.options_.software_version,
            .sync_period = nodes_.options_.sync_period};
  }

  [[nodiscard]] DriveView view_of(const client::AxisSnapshot& drive) {
    is_owned_ = drive.owner_session == nodes_.options_.session;
    return {.status = drive.status, .is_owned = is_owned_};
  }

  BenchNodes& nodes_;
  const std::size_t place_;
  const NodePlace ids_;
  bool is_owned_ = false;
  bool is_loss_untold_ = false;
  bool is_bus_off_ = false;
  std::unique_ptr<DuplicateNode> duplicate_;
  std::vector<std::uint16_t> identifiers_;
  std::optional<std::uint64_t> known_changes_;  ///< Node::parameter_changes() of identifiers_
  std::optional<DriveAccess> accessed_;         ///< pending, with the node's ticket
  std::uint32_t last_ticket_ = 0;               ///< of that access in NodeDrives
  std::vector<ObjectAddress> read_objects_;     ///< for its TPDOs
  std::optional<std::uint64_t> asked_changes_;  ///< Node::parameter_changes() of read_objects_
  std::uint32_t read_ticket_ = 0;               ///< of the last request for them
  DriveTime asked_at_{};                        ///< of the last request for them
  bool is_asked_ = false;                       ///< the last request is unanswered
  std::optional<Node> node_;
};

BenchNodes::BenchNodes(Bus& bus, NodeStore& store, NodeDrives& drives,
                       std::span<const NodePlace> places, const Options& options)
    : bus_(bus), store_(store), drives_(drives), options_(options) {
  slots_.reserve(places.size());
  for (const NodePlace& place : places) {
    slots_.push_back(std::make_unique<Slot>(*this, slots_.size(), place));
  }
  bus_.attach(*this);
}

BenchNodes::~BenchNodes() {
  bus_.detach(*this);
}

void BenchNodes::start(std::span<const client::AxisSnapshot> drives, DriveTime now) {
  ensure(drives.size() == slots_.size(), "each node has its drive");
  stop();
  now_ = now;
  // Nodes that start later, or again, continue the time of those already present.
  if (!options_.sync_period) begin_ = now - bus_.faults().now();
  is_running_ = true;
  are_listeners_old_ = true;
  are_mappings_new_ = true;
  for (std::size_t place = 0; place < slots_.size(); ++place) slots_[place]->start(drives[place]);
  settle();
}

void BenchNodes::stop() {
  is_running_ = false;
  for (const auto& slot : slots_) slot->stop();
  outgoing_.clear();
  late_.clear();
  drive_calls_.clear();
  (void)take_set_points();
}

void BenchNodes::update(std::span<const client::AxisSnapshot> drives, DriveTime now) {
  ensure(drives.size() == slots_.size(), "each node has its drive");
  if (!is_running_) return;
  now_ = std::max(now_, now);
  bus_.faults().pass_to(fault_time());
  follow_faults();
  for (std::size_t place = 0; place < slots_.size(); ++place) {
    // First, so that an answer within this call belongs to the same tick.
    slots_[place]->ask_for_values();
    slots_[place]->update(drives[place]);
    note_changes(place);
  }
  release_late_frames();
  settle();
}

void BenchNodes::complete(std::size_t place, std::uint32_t ticket, const DriveAnswer& answer) {
  if (!is_running_) return;
  slots_.at(place)->complete(ticket, answer);
  note_changes(place);  // the answered request may have changed parameters
  settle();
}

void BenchNodes::take_values(std::size_t place, std::uint32_t ticket,
                             std::span<const DriveValue> values) {
  if (is_running_) slots_.at(place)->take_values(ticket, values);
}

void BenchNodes::note_refused_set_points(std::uint16_t axis, std::uint64_t count) {
  for (const auto& slot : slots_) {
    if (slot->ids().axis == axis && slot->node()) slot->node()->note_refused_set_points(count);
  }
}

std::vector<client::SetPointFrame> BenchNodes::take_set_points() {
  are_noted_ = false;
  return set_points_.take();
}

// ---- frames ----------------------------------------------------------------------------------

void BenchNodes::deliver(const Frame& frame) {
  if (!is_running_) return;
  // Checked first: time passes for the sender of SYNC even if a fault keeps the SYNC from the
  // nodes.
  const bool lets_time_pass = options_.sync_period && is_sync(frame);
  receive({.frame = frame, .number = bus_.frames()});
  settle();
  if (lets_time_pass) drives_.pass_sync();
}

/// Uses the COB-ID of the first node: one bench has one clock.
bool BenchNodes::is_sync(const Frame& frame) const {
  if (frame.is_extended || frame.is_remote) return false;
  const Node& node = *slots_.front()->node();
  const std::uint8_t size = node.value(kSyncCounterOverflow).value_or(0) == 0 ? 0 : 1;
  const auto cob_id = node.value(kCobIdOfSync);
  return frame.size == size && cob_id &&
         frame.id == static_cast<std::uint32_t>(*cob_id & kHighestBaseId);
}

void BenchNodes::receive(const Incoming& incoming) {
  if (are_listeners_old_) refresh_listeners();
  const Listeners::Answer whom = listeners_.find(incoming.frame);
  if (whom.kind == Listeners::Kind::one) give(whom.place, incoming);
  if (whom.kind == Listeners::Kind::everybody) {
    for (std::size_t place = 0; place < slots_.size(); ++place) give(place, incoming);
  }
  if (bus_.faults().empty()) return;
  for (const auto& slot : slots_) {
    if (DuplicateNode* const duplicate = slot->duplicate()) {
      duplicate->receive(incoming.frame, now_);
    }
  }
}

void BenchNodes::give(std::size_t place, const Incoming& incoming) {
  if (slots_[place]->node() == nullptr || place == incoming.sender) return;
  if (bus_.faults().empty()) return give_now(place, incoming.frame);
  const FrameFate fate = bus_.faults().fate_of(
      slots_[place]->ids().node_id, FrameDirection::received, incoming.number, fault_time());
  int copies = copies_now(fate, {incoming.frame, place, FrameDirection::received});
  for (; copies > 0; --copies) give_now(place, incoming.frame);
}

void BenchNodes::give_now(std::size_t place, const Frame& frame) {
  slots_[place]->node()->receive(frame, now_);
  note_changes(place);
}

// ---- faults of the bus -----------------------------------------------------------------------

/// @return how often the frame passes now; a late one is queued.
int BenchNodes::copies_now(const FrameFate& fate, const LateFrame& frame) {
  if (fate.is_lost) return 0;
  const int copies = fate.is_doubled ? 2 : 1;
  if (fate.delay == DriveTime{}) return copies;
  for (int i = 0; i < copies; ++i) {
    if (late_.size() >= Bus::kMostAtOnce) {
      bus_.note_dropped(1);
    } else {
      late_.emplace(now_ + fate.delay, frame);
    }
  }
  return 0;
}

/// Called only with a new tick: in real time, a fault that begins or ends at any other moment would
/// not be reproducible.
void BenchNodes::follow_faults() {
  for (const auto& slot : slots_) slot->follow_faults();
}

void BenchNodes::release_late_frames() {
  while (!late_.empty() && late_.begin()->first <= now_) {
    const LateFrame late = late_.extract(late_.begin()).mapped();
    if (late.direction == FrameDirection::sent) {
      outgoing_.push_back({.frame = late.frame, .place = late.place, .is_late = true});
    } else {
      give_now(late.place, late.frame);
    }
  }
}

void BenchNodes::note_changes(std::size_t place) {
  if (!slots_[place]->has_new_parameters()) return;
  are_listeners_old_ = true;
  are_mappings_new_ = true;
}

/// Fetches the values of a new mapping without waiting for the next tick: on a bench stepped by
/// SYNC there is none before the SYNC that sends the TPDO.
void BenchNodes::ask_for_new_values() {
  if (!is_running_ || !std::exchange(are_mappings_new_, false)) return;
  for (const auto& slot : slots_) slot->ask_for_new_values();
}

void BenchNodes::refresh_listeners() {
  are_listeners_old_ = false;
  listeners_.clear();
  for (std::size_t place = 0; place < slots_.size(); ++place) {
    Slot& slot = *slots_[place];
    if (slot.node() == nullptr) continue;
    listeners_.add(place, {.id = slot.ids().node_id, .identifiers = slot.identifiers()});
  }
}

/// After a call of a node: carries out its requests, and those that follow from them.
void BenchNodes::settle() {
  if (is_settling_) return;  // the outer call does it
  is_settling_ = true;
  std::size_t frames = 0;
  while (!outgoing_.empty() || !drive_calls_.empty()) {
    sending_.swap(outgoing_);
    frames += sending_.size();
    if (frames > Bus::kMostAtOnce) {
      bus_.note_dropped(sending_.size());
      sending_.clear();
    }
    for (const Outgoing& outgoing : sending_) send(outgoing);
    sending_.clear();
    run_drive_calls();
  }
  is_settling_ = false;
  ask_for_new_values();
  if (set_points_.is_empty() || std::exchange(are_noted_, true)) return;
  drives_.note_set_points();
}

void BenchNodes::send(const Outgoing& outgoing) {
  if (bus_.faults().empty() || outgoing.is_late) return send_now(outgoing);
  const FrameFate fate = bus_.faults().fate_of(slots_[outgoing.place]->ids().node_id,
                                               FrameDirection::sent, ++sent_, fault_time());
  int copies = copies_now(fate, {outgoing.frame, outgoing.place, FrameDirection::sent});
  for (; copies > 0; --copies) send_now(outgoing);
}

void BenchNodes::send_now(const Outgoing& outgoing) {
  const std::uint64_t number = bus_.send(outgoing.frame, this);
  // The bus delivers it to the other ports only; the other nodes of this port receive it here.
  if (is_running_) {
    receive({.frame = outgoing.frame, .number = number, .sender = outgoing.place});
  }
}

void BenchNodes::run_drive_calls() {
  for (const auto& call : std::exchange(drive_calls_, {})) {
    if (is_running_) call();
  }
}

// ---- access ----------------------------------------------------------------------------------

NodeCounters BenchNodes::counters() const {
  NodeCounters sum = ended_;
  for (const auto& slot : slots_) {
    if (const Node* const node = slot->node()) add_counters(sum, node->counters());
  }
  return sum;
}

const Node* BenchNodes::node(std::size_t place) const {
  return slots_.at(place)->node();
}

}  // namespace vdrive::canopen
