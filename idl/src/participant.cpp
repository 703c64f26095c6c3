// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/participant.hpp"

#include "backend.hpp"
#include "network_backend.hpp"

namespace vdrive::wire {

Participant::Participant(const NetworkSettings& settings, const std::string& name)
    : backend_(settings.bus != nullptr ? make_local_backend(settings, name)
                                       : make_network_backend(settings, name)) {}

Participant::~Participant() = default;

Source Participant::source() const noexcept {
  return backend_->source();
}

void Participant::announce_again() {
  backend_->announce_again();
}

std::vector<OtherParticipant> Participant::others(std::string_view beginning) const {
  return backend_->others(beginning);
}

bool Participant::knows_who_is_there() const noexcept {
  return backend_->knows_who_is_there();
}

bool Participant::has(const Source& source) const noexcept {
  return backend_->has(source);
}

LocalWork Participant::run_local_work(std::uint32_t bench) {
  return backend_->run_local_work(bench);
}

bool Participant::make_room(std::uint32_t bench) {
  return backend_->make_room(bench);
}

std::string Participant::place() const {
  return backend_->place();
}

std::uint32_t Participant::domain() const noexcept {
  return backend_->domain();
}

bool Participant::is_closed() const noexcept {
  return backend_->is_closed();
}

std::uint64_t Participant::join_clock(const ClockOfBench& clock, std::uint64_t session) {
  return backend_->join_clock(clock, session);
}

void Participant::leave_clock(const ClockOfBench& clock, std::uint64_t session) noexcept {
  backend_->leave_clock(clock, session);
}

void Participant::leave_clocks(std::uint64_t session) noexcept {
  backend_->leave_clocks(session);
}

GuardCounts Participant::guard_counts() const {
  return backend_->guard_counts();
}

}  // namespace vdrive::wire
