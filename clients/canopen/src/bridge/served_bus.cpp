// SPDX-License-Identifier: Apache-2.0
#include "bridge/served_bus.hpp"

#include "topic_names.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/wording.hpp"
#include "wall_time.hpp"

#include <algorithm>
#include <utility>
#include <variant>

namespace vdrive::canopen {
namespace {

using namespace literals;

std::vector<std::uint32_t> numbers_of(const std::vector<BenchSetting>& benches) {
  std::vector<std::uint32_t> numbers;
  numbers.reserve(benches.size());
  for (const BenchSetting& bench : benches) numbers.push_back(bench.number);
  return numbers;
}

std::uint32_t default_value(ObjectRow row) {
  return static_cast<std::uint32_t>(vdrive::describe(row).default_value);
}

GatewaySettings gateway_settings(std::uint16_t network) {
  return {.network = network,
          .vendor_id = default_value("vendor_id"_object),
          .product_code = default_value("product_code"_object),
          .revision_number = default_value("revision_number"_object)};
}

const client::BenchInfo* find_info(const std::vector<client::BenchInfo>& present,
                                   std::uint32_t bench) {
  const auto found = std::ranges::find(present, bench, &client::BenchInfo::number);
  return found == present.end() ? nullptr : &*found;
}

}  // namespace

ServedBus::ServedBus(const BridgeParts& shared, const Settings& settings, const BusSetting& setting,
                     std::uint16_t number)
    : shared_(shared),
      setting_(setting),
      sync_steps_(settings.sync_steps),
      label_("bus " + std::to_string(number)),
      number_(number),
      store_(settings.state, setting.name, shared.reports),
      roster_(*this, numbers_of(setting.benches)) {
  for (const BusFault& fault : setting.faults) (void)bus_.faults().add(fault, {});
  open_ports();
}

ServedBus::~ServedBus() = default;

void ServedBus::open_ports() {
  // The first of all ports, so that the log has each frame before its answers.
  if (!setting_.log.empty()) {
    log_ =
        std::make_unique<BusLog>(shared_.loop, bus_, *this,
                                 BusLogSettings{.file = setting_.log, .interface = setting_.name});
  }
  // If time waits for SYNC, it can also wait for slow readers of the answers.
  const bool holds_bus = sync_steps_.has_value();
  for (const TcpAddress& address : setting_.socketcand) {
    socketcand_.push_back(std::make_unique<SocketcandServer>(
        shared_.loop, bus_, *this, SocketcandSettings{.listen = address, .holds_bus = holds_bus}));
  }
  for (const TcpAddress& address : setting_.gateways) {
    gateways_.push_back(std::make_unique<AsciiGatewayServer>(
        shared_.loop, bus_, *this,
        AsciiGatewayServerSettings{.listen = address, .gateway = gateway_settings(number_)}));
  }
  for (const std::string& interface : setting_.interfaces) {
    interfaces_.push_back(std::make_unique<SocketCan>(
        shared_.loop, bus_, *this,
        SocketCanSettings{.interface = interface, .holds_bus = holds_bus}));
  }
}

void ServedBus::report(bridge::Severity severity, const std::string& port,
                       const std::string& text) {
  shared_.reports.report(severity, port.empty() ? label_ : label_ + ": " + port, text);
}

std::chrono::microseconds ServedBus::frame_time() const {
  if (sync_steps_) return drive_time();
  return std::chrono::floor<std::chrono::microseconds>(
      std::chrono::nanoseconds(bridge::wall_time()));
}

/// @return why the fault cannot be started
std::optional<std::string> ServedBus::disturb(std::uint8_t node, std::string_view text) {
  if (node != 0 && !ids_.contains(node)) {
    return label_ + " has no node " + std::to_string(node) + "; it has " + ids_.text();
  }
  if (text == "none") {
    bus_.faults().clear(node);
    return std::nullopt;
  }
  const DriveTime now = fault_time();
  auto parsed = parse_bus_fault(text, now);
  if (auto* const refusal = std::get_if<std::string>(&parsed)) return std::move(*refusal);
  auto& fault = std::get<BusFault>(parsed);
  fault.node = node;
  if (bus_.faults().add(fault, now)) return std::nullopt;
  return "there are already " + std::to_string(BusFaults::kMostFaults) +
         " faults; clear some with '_disturb none'";
}

void ServedBus::report(bridge::Severity severity, std::uint32_t bench,
                       const std::string& text) const {
  shared_.reports.report(severity, label_ + ": bench " + std::to_string(bench), text);
}

// ---- benches ---------------------------------------------------------------------------------

void ServedBus::find(const std::vector<client::BenchInfo>& present, Clock::time_point now) {
  (void)roster_.take(present, now);
  for (auto& [number, bench] : benches_) {
    if (bench.stepped) bench.stepped->poll(find_info(present, number));
  }
}

/// @return whether the nodes of the known bench continue as those of the found one.
bool ServedBus::continues(const client::BenchInfo& known, const client::BenchInfo& found) const {
  return known.clock_mode == found.clock_mode && known.period == found.period &&
         bridge::are_same_axes(known.axes, found.axes);
}

std::int32_t ServedBus::offset_of(std::uint32_t bench) const {
  const auto named = std::ranges::find(setting_.benches, bench, &BenchSetting::number);
  return named == setting_.benches.end() ? setting_.node_offset : named->node_offset;
}

std::optional<std::string> ServedBus::add(const client::BenchInfo& info) {
  if (sync_steps_) {
    if (auto refusal = SteppedBench::refusal_of(info, *sync_steps_)) return refusal;
  }
  const std::int32_t offset = offset_of(info.number);
  if (auto refusal = ids_.add(info.axes, offset)) return refusal;
  std::vector<NodePlace> places;
  for (const client::AxisInfo& axis : info.axes) {
    places.push_back({.axis = axis.id.axis, .node_id = node_id_of(axis.id, offset)});
  }
  const BusParts parts{.loop = shared_.loop,
                       .session = shared_.session,
                       .reports = shared_.reports,
                       .bus = bus_,
                       .store = store_};
  const std::string label = label_ + ": bench " + std::to_string(info.number);
  ServedBench& served = benches_[info.number];
  if (sync_steps_) {
    served.stepped = std::make_unique<SteppedBench>(parts, info, places, label, *sync_steps_);
  } else {
    served.drives = std::make_unique<BenchDrives>(parts, info, places, label);
  }
  report(bridge::Severity::info, info.number,
         "found, " + counted(places.size(), "axis", "axes") + "; the bus has " + ids_.text());
  return std::nullopt;
}

void ServedBus::leave_out(const client::BenchInfo& info, const std::string& reason) {
  report(bridge::Severity::error, info.number, "is not served: " + reason);
}

void ServedBus::remove(std::uint32_t bench, bool /*is_replaced*/) {
  ids_.remove(bench);
  const auto served = benches_.find(bench);
  ensure(served != benches_.end(), "a bench that was added is served");
  add_counters(ended_, served->second.nodes().counters());
  if (served->second.drives) {
    dropped_set_points_ += served->second.drives->dropped_set_points();
    // The link is destroyed in another thread: that may block on the bench that has gone.
    (void)shared_.closer.post([ending = served->second.drives->close()] {});
  }
  benches_.erase(served);
  report(bridge::Severity::info, bench, "has gone; the bus has " + ids_.text());
}

void ServedBus::note_refused_set_points(const client::SetPointRefusal& refusal,
                                        std::uint64_t count) {
  const auto served = benches_.find(refusal.axis.bench);
  if (served == benches_.end()) return;
  if (served->second.drives) {
    served->second.drives->note_refused_set_points(refusal.axis.axis, count);
  } else {
    served->second.stepped->note_refused_set_points(refusal.axis.axis, count);
  }
  const std::uint8_t node = node_id_of(refusal.axis, offset_of(refusal.axis.bench));
  constexpr std::size_t kAbortDigits = 8;
  // The report leaves out the value: equal reports are limited to one per second.
  shared_.reports.report(bridge::Severity::warning, label_ + ": node " + std::to_string(node),
                         "the drive refuses the value of a PDO for " +
                             address_text(refusal.object) + ": " +
                             hex(wire_code(refusal.code), kAbortDigits) + ", " +
                             std::string(vdrive::describe(refusal.code)));
}

/// The time of the bench that is furthest ahead: each bench has its own clock, and SYNC advances
/// all of them.
std::chrono::microseconds ServedBus::drive_time() const {
  DriveTime time{};
  for (const auto& [number, bench] : benches_) time = std::max(time, bench.nodes().now());
  return time;
}

/// As BenchNodes::fault_time(). A stepped bench that restarts counts from 0 again.
DriveTime ServedBus::fault_time() const {
  return sync_steps_ ? drive_time() : bus_.faults().now();
}

// ---- access ----------------------------------------------------------------------------------

std::optional<TcpAddress> ServedBus::socketcand() const {
  if (socketcand_.empty()) return std::nullopt;
  return socketcand_.front()->address();
}

std::optional<TcpAddress> ServedBus::gateway() const {
  if (gateways_.empty()) return std::nullopt;
  return gateways_.front()->address();
}

const BenchNodes* ServedBus::nodes(std::uint32_t bench) const {
  const auto served = benches_.find(bench);
  return served == benches_.end() ? nullptr : &served->second.nodes();
}

bool ServedBus::are_all_there() const {
  return std::ranges::all_of(setting_.benches, [this](const BenchSetting& bench) {
    const BenchNodes* const its = nodes(bench.number);
    return its != nullptr && its->is_running();
  });
}

std::vector<std::string> ServedBus::left_out() const {
  std::vector<std::string> lines;
  for (const auto& [bench, reason] : roster_.left_out()) {
    lines.push_back(label_ + ": bench " + std::to_string(bench) + ": " + reason);
  }
  return lines;
}

std::string ServedBus::description() const {
  std::string text = label_ + ": " + ids_.text();
  for (const auto& server : socketcand_) text += ", socketcand " + address_text(server->address());
  for (const auto& server : gateways_) text += ", gateway " + address_text(server->address());
  for (const std::string& interface : setting_.interfaces) text += ", interface " + interface;
  const bool has_port = !(socketcand_.empty() && gateways_.empty() && interfaces_.empty());
  if (has_port && socketcand_.empty()) text += ", no socketcand";
  if (has_port && gateways_.empty()) text += ", no gateway";
  return text;
}

std::string ServedBus::counters() const {
  NodeCounters nodes = ended_;
  std::uint64_t dropped = dropped_set_points_;
  for (const auto& [number, bench] : benches_) {
    add_counters(nodes, bench.nodes().counters());
    if (bench.drives) dropped += bench.drives->dropped_set_points();
  }
  std::uint64_t unread = 0;
  std::uint64_t refused_words = 0;
  for (const auto& server : socketcand_) {
    unread += server->counters().dropped_frames;
    refused_words += server->counters().refused_words;
  }
  for (const auto& port : interfaces_) unread += port->counters().dropped_frames;
  return label_ + ": " + std::to_string(bus_.frames()) + " frames, " +
         std::to_string(nodes.dropped_pdos) + " dropped PDOs, " +
         std::to_string(nodes.ignored_set_points) + " PDOs ignored for another session, " +
         std::to_string(nodes.refused_set_points) + " refused values of PDOs, " +
         std::to_string(dropped) + " dropped set-points, " + std::to_string(nodes.sdo_aborts) +
         " SDO aborts, " + std::to_string(nodes.sdo_time_outs) + " SDO time-outs, " +
         std::to_string(nodes.ignored_frames) + " malformed frames, " +
         std::to_string(nodes.held_back_emergencies) + " emergencies held back, " +
         std::to_string(unread) + " frames not read in time, " + std::to_string(refused_words) +
         " refused words, " + std::to_string(bus_.dropped_frames()) +
         " frames dropped (reply limit), " + std::to_string(bus_.faults().disturbed_frames()) +
         " frames disturbed";
}

}  // namespace vdrive::canopen
