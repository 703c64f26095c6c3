// SPDX-License-Identifier: Apache-2.0
#include "node/pdos.hpp"

#include "vdrive/assert.hpp"

#include <algorithm>
#include <cstddef>

namespace vdrive::canopen {
namespace {

// The objects of PDO 1 have these indices, followed by those of the next PDOs.
constexpr unsigned kReceiveParameters = 0x1400;
constexpr unsigned kReceiveMappings = 0x1600;
constexpr unsigned kTransmitParameters = 0x1800;
constexpr unsigned kTransmitMappings = 0x1A00;

constexpr unsigned kNumberMask = 0x01FF;  // 512 PDOs in each range

bool is_of_receive_pdo(ObjectAddress object) {
  const unsigned range = object.index & ~kNumberMask;
  return range == kReceiveParameters || range == kReceiveMappings;
}

bool is_of_transmit_pdo(ObjectAddress object) {
  const unsigned range = object.index & ~kNumberMask;
  return range == kTransmitParameters || range == kTransmitMappings;
}

/// @return the position of the PDO that has this object.
std::size_t position_of(ObjectAddress object) {
  return object.index & kNumberMask;
}

void put_earlier(std::optional<DriveTime>& first, const std::optional<DriveTime>& other) {
  if (other && (!first || *other < *first)) first = other;
}

}  // namespace

Pdos::Pdos(std::uint8_t node_id, PdoHost& host, std::optional<std::uint32_t> sync_period)
    : host_(host), sync_(sync_period) {
  receive_.reserve(kPdoCount);
  transmit_.reserve(kPdoCount);
  for (std::uint8_t number = 1; number <= kPdoCount; ++number) {
    const PdoPlace place{.number = number, .node_id = node_id};
    receive_.emplace_back(place);
    transmit_.emplace_back(place);
  }
}

bool Pdos::has(ObjectAddress object) noexcept {
  if (SyncConsumer::has(object)) return true;
  return (is_of_receive_pdo(object) || is_of_transmit_pdo(object)) &&
         position_of(object) < kPdoCount;
}

std::uint32_t Pdos::read(ObjectAddress object) const {
  ensure(has(object), "a read object is one of the PDOs or of SYNC");
  if (is_of_receive_pdo(object)) return receive_[position_of(object)].read(object);
  if (is_of_transmit_pdo(object)) return transmit_[position_of(object)].read(object);
  return sync_.read(object);
}

AbortCode Pdos::write(ObjectAddress object, std::uint32_t value) {
  ensure(has(object), "a written object is one of the PDOs or of SYNC");
  if (is_of_receive_pdo(object)) return receive_[position_of(object)].write(object, value);
  if (is_of_transmit_pdo(object)) return transmit_[position_of(object)].write(object, value);
  return sync_.write(object, value);
}

void Pdos::reset() {
  stop();
  sync_.reset();
  for (ReceivePdo& pdo : receive_) pdo.reset();
  for (TransmitPdo& pdo : transmit_) pdo.reset();
}

void Pdos::start(const AxisStatus& drive, DriveTime now) {
  restart();
  is_started_ = true;
  update(drive, now);
}

void Pdos::stop() {
  is_started_ = false;
  restart();
}

bool Pdos::receive(const Frame& frame, DriveTime now) {
  if (frame.is_extended) return false;
  if (frame.is_remote) return answer(frame, now);
  // SYNC first: an RPDO with the CAN-ID of SYNC waits for the next SYNC.
  bool is_mine = sync_.is_sync(frame);
  if (is_mine && is_started_) synchronise(frame, now);
  for (ReceivePdo& pdo : receive_) {
    if (!pdo.awaits(frame)) continue;
    is_mine = true;
    take(pdo, frame, now);
  }
  return is_mine;
}

void Pdos::update(const AxisStatus& drive, DriveTime now) {
  drive_ = drive;
  if (is_started_) send_due(now);
}

std::vector<ObjectAddress> Pdos::read_objects() const {
  std::vector<ObjectAddress> objects;
  for (const TransmitPdo& pdo : transmit_) pdo.add_read_objects(objects);
  return objects;
}

void Pdos::set_value(const DriveValue& reading) {
  for (TransmitPdo& pdo : transmit_) pdo.set_value(reading);
}

void Pdos::advance(DriveTime now) {
  if (!is_started_) return;
  send_due(now);
  for (ReceivePdo& pdo : receive_) {
    if (pdo.times_out(now)) raise(kPdoTimeOut);
  }
}

bool Pdos::has_error() const noexcept {
  return sync_.has_error() || std::ranges::any_of(receive_, &ReceivePdo::has_error);
}

std::optional<DriveTime> Pdos::next_due() const {
  std::optional<DriveTime> due;
  if (!is_started_) return due;
  for (const ReceivePdo& pdo : receive_) put_earlier(due, pdo.next_due());
  for (const TransmitPdo& pdo : transmit_) put_earlier(due, pdo.next_due());
  return due;
}

void Pdos::restart() {
  sync_.restart();
  for (ReceivePdo& pdo : receive_) pdo.restart();
  for (TransmitPdo& pdo : transmit_) pdo.restart();
}

void Pdos::synchronise(const Frame& sync, DriveTime now) {
  const SyncReception reception = sync_.receive(sync, now);
  raise(reception.error_code);
  if (!reception.is_used) return;
  for (TransmitPdo& pdo : transmit_) send(pdo.synchronise(drive_, reception.counter));
  std::uint8_t taken = 0;
  for (ReceivePdo& pdo : receive_) {
    if (pdo.take(set_points_)) ++taken;
  }
  command(taken);
}

bool Pdos::answer(const Frame& request, DriveTime now) {
  bool is_mine = false;
  for (TransmitPdo& pdo : transmit_) {
    if (!pdo.is_request(request)) continue;
    is_mine = true;
    if (is_started_) send(pdo.answer(drive_, now));
  }
  return is_mine;
}

void Pdos::take(ReceivePdo& pdo, const Frame& frame, DriveTime now) {
  const bool is_late = pdo.is_synchronous() && sync_.is_window_over(now);
  if (!is_started_ || is_late) {
    ++counters_.dropped;
    return;
  }
  const PdoReception reception = pdo.receive(frame, now);
  if (reception.is_dropped) ++counters_.dropped;
  raise(reception.error_code);
  if (pdo.is_synchronous()) return;
  if (pdo.take(set_points_)) command(1);
}

void Pdos::send_due(DriveTime now) {
  for (TransmitPdo& pdo : transmit_) send(pdo.send_due(drive_, now));
}

void Pdos::send(const std::optional<Frame>& frame) {
  if (frame) host_.send(*frame);
}

void Pdos::raise(std::uint16_t error_code) {
  if (error_code != 0) host_.raise(error_code);
}

/// An RPDO with nothing but dummies brings no values.
void Pdos::command(std::uint8_t pdos) {
  if (!set_points_.values().empty()) host_.command(set_points_.values(), pdos);
  set_points_.clear();
}

}  // namespace vdrive::canopen
