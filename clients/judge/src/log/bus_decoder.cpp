// SPDX-License-Identifier: Apache-2.0
#include "log/bus_decoder.hpp"

#include "judge/axis_track.hpp"
#include "judge/words.hpp"
#include "node/cob_id.hpp"
#include "node/node_object.hpp"
#include "node/node_settings.hpp"
#include "node/pdo_mapping.hpp"
#include "node/pdo_parameters.hpp"

#include <algorithm>
#include <deque>
#include <utility>

namespace vdrive::judge {
namespace {

using canopen::Frame;
using canopen::NmtService;
using canopen::NmtState;
using canopen::PdoDirection;

constexpr std::uint32_t kTimeStampId = 0x100;
constexpr std::uint32_t kLssAnswerId = 0x7E4;
constexpr std::uint32_t kLssRequestId = 0x7E5;
constexpr std::uint32_t kNodeBits = 0x7F;
constexpr std::uint32_t kFunctionBits = 0x780;
constexpr std::size_t kLeastEmergency = 2;  // bytes with the error code
constexpr std::uint32_t kServoProfile = 402;

// Limits for records kept until a node is known to be a drive, and for records that wait for the
// answer to a download.
constexpr std::size_t kMostEarly = 64;
constexpr std::size_t kMostHeld = 256;

constexpr std::uint8_t kToggleOfGuarding = 0x80;

constexpr ObjectAddress kDeviceType{0x1000, 0};
constexpr ObjectAddress kSyncCobId{0x1005, 0};
constexpr std::uint16_t kConsumerHeartbeat = 0x1016;

std::optional<NodeState> state_of(std::uint8_t byte) {
  switch (static_cast<NmtState>(byte)) {
    case NmtState::boot_up:
      return NodeState::initialising;
    case NmtState::stopped:
      return NodeState::stopped;
    case NmtState::operational:
      return NodeState::operational;
    case NmtState::pre_operational:
      return NodeState::pre_operational;
    default:
      return std::nullopt;
  }
}

/// Adds an object of a PDO or of an SDO upload to the state shown by the drive.
void show(ObjectAddress object, std::int64_t value, Shown& shown) {
  const auto put = [&](std::uint16_t member, auto& place) {
    place = static_cast<std::remove_reference_t<decltype(place)>>(value);
    shown.members |= member;
  };
  if (object == objects::kStatusword) put(ShownMember::kStatusword, shown.statusword);
  if (object == objects::kModeShown) put(ShownMember::kMode, shown.mode);
  if (object == objects::kPosition) put(ShownMember::kPosition, shown.position);
  if (object == objects::kPositionDemand) put(ShownMember::kDemand, shown.demand);
  if (object == objects::kFollowingError) put(ShownMember::kFollowingError, shown.following_error);
  if (object == objects::kTorque) put(ShownMember::kTorque, shown.torque);
  if (object == objects::kErrorCode) put(ShownMember::kErrorCode, shown.error_code);
}

bool is_no_word(const Write& write) {
  return write.object != objects::kControlword;
}

std::string pdo_name(const PdoRef& ref) {
  return std::string(ref.direction == PdoDirection::receive ? "RPDO " : "TPDO ") +
         std::to_string(ref.number) + " of node " + std::to_string(ref.node);
}

std::string entries_text(const LoggedPdo& pdo) {
  std::string text;
  for (const LoggedEntry& entry : pdo.entries()) {
    text.append(text.empty() ? "" : " + ").append(object_name(entry.object));
  }
  return text;
}

}  // namespace

/// The last frame of an RPDO whose transmission type makes it wait for SYNC.
struct SynchronousPdo {
  std::uint64_t line = 0;
  std::vector<Write> writes;
};

/// A heartbeat that a node consumes (1016h).
struct Consumed {
  std::uint8_t producer = 0;
  Time limit{};
};

/// All that is known about a node.
struct BusDecoder::Node {
  Node(std::uint8_t its_number, const canopen::DataSheet* sheet)
      : number(its_number), pdos(its_number, sheet) {}

  std::uint8_t number;
  LoggedPdos pdos;
  std::vector<std::uint32_t> indexed;  ///< CAN-IDs of `pdos`
  SdoObserver sdo;
  bool is_drive = false;
  bool is_no_drive = false;      ///< 1000h names another profile
  bool has_stored = false;       ///< 1010h was written: a restart keeps the mapping
  std::deque<Record> early;      ///< from before it was known to be a drive
  std::optional<Write> written;  ///< a download that the node has not confirmed yet
  Time written_time{};
  std::uint64_t written_line = 0;
  std::deque<Record> held;                          ///< records after that write
  std::map<std::uint8_t, Consumed> consumed;        ///< heartbeats, by the sub-index of 1016h
  std::map<std::uint16_t, SynchronousPdo> waiting;  ///< RPDOs waiting for SYNC, by number
  std::map<std::string, std::uint64_t> assumed;     ///< notes, with the number of frames
};

std::string_view to_string(FrameKind kind) noexcept {
  switch (kind) {
    case FrameKind::nmt:
      return "nmt";
    case FrameKind::sync:
      return "sync";
    case FrameKind::emergency:
      return "emergency";
    case FrameKind::time_stamp:
      return "time_stamp";
    case FrameKind::transmit_pdo:
      return "transmit_pdo";
    case FrameKind::receive_pdo:
      return "receive_pdo";
    case FrameKind::sdo_response:
      return "sdo_response";
    case FrameKind::sdo_request:
      return "sdo_request";
    case FrameKind::heartbeat:
      return "heartbeat";
    case FrameKind::lss:
      return "lss";
    case FrameKind::foreign:
      return "foreign";
  }
  return {};
}

BusDecoder::BusDecoder(DecoderSettings settings, Sink sink)
    : settings_(std::move(settings)), sink_(std::move(sink)), sync_id_(canopen::kSyncId) {
  for (std::uint8_t number = 1; number <= canopen::kHighestNodeId; ++number) {
    if (is_wanted(number)) index_pdos(number);
  }
}

BusDecoder::~BusDecoder() = default;

bool BusDecoder::is_wanted(std::uint8_t number) const {
  return settings_.nodes.empty() || settings_.nodes.contains(number);
}

BusDecoder::Node& BusDecoder::node_of(std::uint8_t number) {
  return nodes_.try_emplace(number, number, settings_.sheet).first->second;
}

/// Called when the CAN-IDs of a node have changed.
void BusDecoder::index_pdos(std::uint8_t number) {
  Node& node = node_of(number);
  for (const std::uint32_t id : std::exchange(node.indexed, {})) {
    std::erase_if(pdos_[id], [number](const PdoRef& ref) {
      return ref.node == number;
    });
  }
  for (const auto& [id, ref] : node.pdos.can_ids()) {
    pdos_[id].push_back(ref);
    node.indexed.push_back(id);
  }
  std::ranges::sort(node.indexed);  // several PDOs may have the same CAN-ID
  node.indexed.erase(std::unique(node.indexed.begin(), node.indexed.end()), node.indexed.end());
}

DecodedFrame BusDecoder::classify(const Frame& frame) const {
  if (frame.is_extended) return {};
  if (frame.id == canopen::kNmtId) return {.kind = FrameKind::nmt};
  if (frame.id == sync_id_) return {.kind = FrameKind::sync};
  if (frame.id == kTimeStampId) return {.kind = FrameKind::time_stamp};
  if (frame.id == kLssAnswerId || frame.id == kLssRequestId) return {.kind = FrameKind::lss};
  const auto& refs = pdos_[frame.id];
  if (!refs.empty()) {
    const PdoRef& ref = refs.front();
    return {.kind = ref.direction == PdoDirection::receive ? FrameKind::receive_pdo
                                                           : FrameKind::transmit_pdo,
            .node = ref.node,
            .pdo_number = ref.number};
  }
  const auto node = static_cast<std::uint8_t>(frame.id & kNodeBits);
  if (node == 0) return {};
  switch (frame.id & kFunctionBits) {
    case canopen::kEmergencyId:
      return {.kind = FrameKind::emergency, .node = node};
    case canopen::kSdoResponseId:
      return {.kind = FrameKind::sdo_response, .node = node};
    case canopen::kSdoRequestId:
      return {.kind = FrameKind::sdo_request, .node = node};
    case canopen::kHeartbeatId:
      return {.kind = FrameKind::heartbeat, .node = node};
    default:
      return {};
  }
}

DecodedFrame BusDecoder::take(Time now, const Frame& frame, std::uint64_t line) {
  line_ = line;
  ++counts_.frames;
  const DecodedFrame decoded = classify(frame);
  // A heartbeat of any node may come from the master.
  if (decoded.kind == FrameKind::heartbeat) {
    take_heartbeat(now, decoded.node, frame);
    return decoded;
  }
  if (decoded.kind == FrameKind::foreign) {
    ++counts_.foreign;
    return decoded;
  }
  if (decoded.node != 0 && !is_wanted(decoded.node)) {
    ++counts_.other_nodes;
    return decoded;
  }
  if (frame.is_remote) return decoded;
  switch (decoded.kind) {
    case FrameKind::nmt:
      take_nmt(now, frame);
      break;
    case FrameKind::sync:
      for (auto& [number, node] : nodes_) {
        if (node.is_drive) put(now, node, Sync{});
        apply_synchronous(now, node);
      }
      break;
    case FrameKind::emergency:
      take_emergency(now, node_of(decoded.node), frame);
      break;
    case FrameKind::transmit_pdo:
    case FrameKind::receive_pdo:
      for (const PdoRef& ref : pdos_[frame.id]) {
        take_pdo(now, node_of(ref.node), ref, frame);
      }
      break;
    case FrameKind::sdo_response:
    case FrameKind::sdo_request:
      take_sdo(now, node_of(decoded.node), frame, decoded.kind == FrameKind::sdo_request);
      break;
    default:
      break;
  }
  return decoded;
}

void BusDecoder::lose(Time now) {
  for (auto& [number, node] : nodes_) {
    release(node);
    node.sdo.forget();
    node.waiting.clear();
    if (node.is_drive) put(now, node, Gap{});
  }
}

void BusDecoder::end(Time now) {
  for (auto& [number, node] : nodes_) {
    apply_synchronous(now, node);
    release(node);
  }
}

// ---- NMT and its error control -----------------------------------------------------------------

void BusDecoder::take_nmt(Time now, const Frame& frame) {
  constexpr std::size_t kNmtSize = 2;
  const std::uint8_t target = frame.data[1];
  if (frame.size != kNmtSize || target > canopen::kHighestNodeId) {
    ++counts_.malformed;
    return;
  }
  const auto command = [&](Node& node) {
    switch (static_cast<NmtService>(frame.data[0])) {
      case NmtService::start:
        return put(now, node, Network{.state = NodeState::operational, .is_command = true});
      case NmtService::stop:
        return put(now, node, Network{.state = NodeState::stopped, .is_command = true});
      case NmtService::enter_pre_operational:
        return put(now, node, Network{.state = NodeState::pre_operational, .is_command = true});
      case NmtService::reset_node:
      case NmtService::reset_communication:
        return restart(now, node, true);
      default:
        ++counts_.malformed;
    }
  };
  if (target != 0) {
    if (is_wanted(target)) command(node_of(target));
    return;
  }
  for (auto& [number, node] : nodes_) command(node);
}

void BusDecoder::restart(Time now, Node& node, bool is_command) {
  release(node);
  node.sdo.forget();
  node.waiting.clear();
  put(now, node, Network{.state = NodeState::initialising, .is_command = is_command});
  if (node.has_stored) return;
  node.consumed.clear();
  node.pdos.reset();
  index_pdos(node.number);
}

void BusDecoder::take_heartbeat(Time now, std::uint8_t number, const Frame& frame) {
  if (frame.is_remote) return;  // a node-guarding request
  const auto state = frame.size == 1
                         ? state_of(frame.data[0] & static_cast<std::uint8_t>(~kToggleOfGuarding))
                         : std::nullopt;
  if (!state) {
    ++counts_.malformed;
    return;
  }
  for (auto& [consumer, node] : nodes_) {
    for (const auto& [subindex, heartbeat] : node.consumed) {
      if (heartbeat.producer == number) put(now, node, KeepAlive{.limit = heartbeat.limit});
    }
  }
  if (!is_wanted(number)) {
    ++counts_.other_nodes;
    return;
  }
  Node& node = node_of(number);
  if (*state != NodeState::initialising) return put(now, node, Network{.state = *state});
  restart(now, node, false);
  put(now, node, Network{.state = NodeState::pre_operational});
}

void BusDecoder::take_emergency(Time now, Node& node, const Frame& frame) {
  if (frame.size < kLeastEmergency) {
    ++counts_.malformed;
    return;
  }
  const auto code = static_cast<std::uint16_t>(
      canopen::little_endian_number(frame.bytes().first(kLeastEmergency)));
  put(now, node, Emergency{.code = code});
}

// ---- PDOs --------------------------------------------------------------------------------------

std::int64_t BusDecoder::value_of(ObjectAddress object, std::span<const std::uint8_t> bytes) const {
  const auto unsigned_number = static_cast<std::int64_t>(canopen::little_endian_number(bytes));
  if (settings_.sheet != nullptr) {
    const auto described = settings_.sheet->find(object);
    if (described != settings_.sheet->end() && described->second.size() != 0) {
      return described->second.is_signed() ? canopen::signed_little_endian_number(bytes)
                                           : unsigned_number;
    }
  }
  const canopen::NodeObject* const known = canopen::find_node_object(object);
  return known == nullptr ? unsigned_number : canopen::number_of(known->data_type, bytes);
}

void BusDecoder::take_pdo(Time now, Node& node, const PdoRef& ref, const Frame& frame) {
  const LoggedPdo* const pdo = node.pdos.find(ref);
  const bool is_assumed = pdo != nullptr && pdo->mapping_origin() == PdoOrigin::profile;
  const bool fits = pdo != nullptr && !pdo->entries().empty() &&
                    (is_assumed ? frame.size == pdo->size() : frame.size >= pdo->size());
  if (!fits) {
    ++counts_.unknown_mapping;
    ++node.assumed[pdo_name(ref) + " has " + std::to_string(frame.size) +
                   " bytes, which does not match its mapping: give the data sheet by --eds, or a "
                   "log that begins before the configuration"];
    return;
  }
  if (is_assumed) {
    ++node.assumed[pdo_name(ref) + " is assumed to map " + entries_text(*pdo) +
                   ", the default of CiA 402: the log does not show its mapping"];
  }
  if (ref.direction == PdoDirection::receive) {
    take_receive_pdo(now, node, ref, *pdo, frame);
  } else {
    take_transmit_pdo(now, node, *pdo, frame);
  }
}

void BusDecoder::take_receive_pdo(Time now, Node& node, const PdoRef& ref, const LoggedPdo& pdo,
                                  const Frame& frame) {
  put(now, node, ReceivePdo{.number = ref.number, .type = pdo.type()});
  std::vector<Write> writes;
  std::size_t place = 0;
  for (const LoggedEntry& entry : pdo.entries()) {
    const auto bytes = frame.bytes().subspan(place, entry.size);
    place += entry.size;
    if (entry.object.index <= canopen::kLastDummy) continue;
    writes.push_back({.object = entry.object,
                      .value = value_of(entry.object, bytes),
                      .channel = Channel::pdo,
                      .fate = Fate::unanswered,
                      .writer = ref.number});
  }
  if (pdo.type() && *pdo.type() <= canopen::kLastSynchronous) {
    node.waiting[ref.number] = {.line = line_, .writes = std::move(writes)};
    return;
  }
  std::stable_partition(writes.begin(), writes.end(), is_no_word);
  for (const Write& write : writes) put(now, node, write);
}

/// SYNC applies everything that has arrived since the previous one; the controlword is applied
/// last.
void BusDecoder::apply_synchronous(Time now, Node& node) {
  const std::uint64_t line = line_;
  const auto waiting = std::exchange(node.waiting, {});
  for (const bool is_word : {false, true}) {
    for (const auto& [number, pdo] : waiting) {
      line_ = pdo.line;
      for (const Write& write : pdo.writes) {
        if (is_no_word(write) != is_word) put(now, node, write);
      }
    }
  }
  line_ = line;
}

void BusDecoder::take_transmit_pdo(Time now, Node& node, const LoggedPdo& pdo, const Frame& frame) {
  Shown shown;
  std::size_t place = 0;
  for (const LoggedEntry& entry : pdo.entries()) {
    show(entry.object, value_of(entry.object, frame.bytes().subspan(place, entry.size)), shown);
    place += entry.size;
  }
  if (shown.members != 0) put(now, node, shown);
}

// ---- SDO ---------------------------------------------------------------------------------------

void BusDecoder::take_sdo(Time now, Node& node, const Frame& frame, bool is_request) {
  if (frame.size != canopen::kMostData) {
    ++counts_.malformed;
    return;
  }
  if (is_request) release(node);  // an earlier request will not be answered any more
  const auto transfer = is_request ? node.sdo.take_request(frame) : node.sdo.take_response(frame);
  if (transfer) finish_sdo(now, node, *transfer);
  const SdoTransfer* const pending = node.sdo.pending_download();
  if (pending == nullptr || node.written || pending->data.empty() ||
      pending->data.size() > sizeof(std::int64_t)) {
    return;
  }
  // The drive may act from now on, even before it answers.
  node.written = Write{.object = pending->object,
                       .value = value_of(pending->object, pending->data),
                       .channel = Channel::sdo,
                       .fate = Fate::unanswered};
  node.written_time = now;
  node.written_line = line_;
}

void BusDecoder::finish_sdo(Time now, Node& node, const SdoTransfer& transfer) {
  const bool has_number = transfer.is_complete && !transfer.data.empty() &&
                          transfer.data.size() <= sizeof(std::int64_t);
  const std::int64_t value = has_number ? value_of(transfer.object, transfer.data) : 0;
  if (transfer.is_download) {
    if (node.written) {
      node.written->fate = transfer.abort == 0 ? Fate::accepted : Fate::refused;
      node.written->code = transfer.abort;
    }
    release(node);
    if (transfer.abort == 0 && has_number) learn(node, transfer.object, value);
    return;
  }
  if (transfer.abort == 0 && !has_number) return;  // a string
  put(now, node, Reading{.object = transfer.object, .value = value, .code = transfer.abort});
  if (transfer.abort != 0) return;
  Shown shown{.is_asked_for = true};
  show(transfer.object, value, shown);
  if (shown.members != 0) put(now, node, shown);
  learn(node, transfer.object, value);
}

void BusDecoder::learn(Node& node, ObjectAddress object, std::int64_t value) {
  const auto bits = static_cast<std::uint32_t>(value);
  if (node.pdos.set(object, bits)) {
    index_pdos(node.number);
  } else if (object == kSyncCobId) {
    sync_id_ = canopen::can_id_of(bits);
  } else if (object == kDeviceType) {
    node.is_no_drive = (bits & 0xFFFFU) != kServoProfile;
  } else if (object == objects::kStore) {
    node.has_stored = true;
  } else if (object.index == kConsumerHeartbeat && object.subindex != 0) {
    const auto producer = static_cast<std::uint8_t>(bits >> 16U & kNodeBits);
    const std::uint32_t milliseconds = bits & 0xFFFFU;
    node.consumed.erase(object.subindex);
    if (producer != 0 && milliseconds != 0) {
      node.consumed[object.subindex] = {.producer = producer,
                                        .limit = std::chrono::milliseconds(milliseconds)};
    }
  }
}

// ---- records -----------------------------------------------------------------------------------

void BusDecoder::put(Time now, Node& node, const decltype(Record::what)& what) {
  const Record record{.time = now, .line = line_, .axis = node.number, .what = what};
  if (!node.written) return pass(node, record);
  node.held.push_back(record);
  if (node.held.size() >= kMostHeld) release(node);
}

/// The write that waited for its answer comes first: the drive acted on it before it answered.
void BusDecoder::release(Node& node) {
  if (!node.written) return;
  const Write write = *std::exchange(node.written, std::nullopt);
  const std::deque<Record> held = std::exchange(node.held, {});
  pass(node,
       {.time = node.written_time, .line = node.written_line, .axis = node.number, .what = write});
  for (const Record& record : held) pass(node, record);
}

void BusDecoder::pass(Node& node, const Record& record) {
  if (node.is_no_drive) return;
  if (node.is_drive) return sink_(record);
  const auto* const write = std::get_if<Write>(&record.what);
  const auto* const shown = std::get_if<Shown>(&record.what);
  node.is_drive = (write != nullptr && write->object == objects::kControlword) ||
                  (shown != nullptr && shown->has(ShownMember::kStatusword));
  node.early.push_back(record);
  if (node.is_drive) {
    for (const Record& early : std::exchange(node.early, {})) sink_(early);
  } else if (node.early.size() > kMostEarly) {
    node.early.pop_front();
  }
}

std::vector<std::string> BusDecoder::notes() const {
  std::vector<std::string> notes;
  for (const auto& [number, node] : nodes_) {
    if (!node.is_drive) continue;
    for (const auto& [text, count] : node.assumed) {
      notes.push_back(text + " (" + std::to_string(count) + " frames)");
    }
  }
  return notes;
}

}  // namespace vdrive::judge
