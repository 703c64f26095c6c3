// SPDX-License-Identifier: Apache-2.0
#include "local/local_participant.hpp"

#include "message_support.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/codec.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstdint>
#include <thread>
#include <utility>

namespace vdrive::wire {
namespace {

/// Numbers of participants and endpoints, unique in the process: a session that uses two buses in
/// succession must not confuse their benches.
std::uint64_t next_number() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

template <std::size_t Size>
void put_number(std::array<std::uint8_t, Size>& bytes, std::uint64_t number) noexcept {
  constexpr unsigned kBitsOfByte = 8;
  for (std::size_t place = Size; place > 0 && number != 0; --place, number >>= kBitsOfByte) {
    bytes[place - 1] = static_cast<std::uint8_t>(number);
  }
}

Source new_source() noexcept {
  Source source;
  put_number(source.participant, next_number());
  source.participant[0] = 'v';  // not all zero, which would mean no participant
  return source;
}

SourceKey as_numbers(const Source& source) noexcept {
  const auto words = std::bit_cast<std::array<std::uint32_t, 3>>(source.participant);
  return {std::uint64_t{words[0]} << 32U | words[1], words[2]};
}

EndpointId new_endpoint(const Source& source) noexcept {
  EndpointId id{.source = source};
  put_number(id.entity, next_number());
  return id;
}

/// Whether a participant in one role ignores one in the other.
bool is_ignored(Role own, Role other) noexcept {
  return own == Role::client && other == Role::client;
}

std::size_t place_of(TopicId topic) noexcept {
  return static_cast<std::size_t>(topic);
}

/// Not the system's thread id, which may be reused after a thread has ended.
std::uint64_t number_of_this_thread() noexcept {
  static std::atomic<std::uint64_t> last{0};
  thread_local const std::uint64_t number = ++last;
  return number;
}

}  // namespace

// ---- bus ---------------------------------------------------------------------------------------

LocalBus::LocalBus() : parts_(std::make_unique<Parts>()) {}

LocalBus::~LocalBus() = default;

std::shared_ptr<LocalBus::Parts::Place> LocalBus::Parts::place_of(std::uint32_t bench) {
  const std::scoped_lock lock(placing);
  const auto found = places.find(bench);
  return found == places.end() ? nullptr : found->second;
}

LocalBus::WorkPlace::WorkPlace(std::shared_ptr<LocalBus> bus, std::uint32_t bench, Work work)
    : bus_(std::move(bus)), bench_(bench) {
  auto place = std::make_shared<Parts::Place>();
  place->work = std::move(work);
  const std::scoped_lock lock(bus_->parts().placing);
  bus_->parts().places[bench_] = std::move(place);
}

LocalBus::WorkPlace::~WorkPlace() {
  std::shared_ptr<Parts::Place> place;
  {
    const std::scoped_lock lock(bus_->parts().placing);
    place = std::move(bus_->parts().places.extract(bench_).mapped());
  }
  // No thread can find the place any more. The lock waits for those that are running its work;
  // others that have already found it see has_ended.
  const std::scoped_lock lock(place->in_use);
  place->has_ended = true;
}

LocalWork LocalBus::run_work(std::uint32_t bench) {
  const auto place = parts_->place_of(bench);
  if (!place) return LocalWork::none;
  const std::shared_lock lock(place->in_use);
  return place->has_ended ? LocalWork::none : place->work.run();
}

bool LocalBus::make_room(std::uint32_t bench) {
  constexpr std::chrono::milliseconds kMoment{1};
  const auto place = parts_->place_of(bench);
  if (!place) return true;
  {
    const std::shared_lock lock(place->in_use);
    if (place->has_ended || place->work.has_room()) return true;
    place->work.run();
    if (place->work.has_room()) return true;
  }
  std::this_thread::sleep_for(kMoment);
  return false;
}

// ---- participant -------------------------------------------------------------------------------

LocalParticipant::LocalParticipant(std::shared_ptr<LocalBus> bus, Role role, std::string name)
    : bus_(std::move(bus)), role_(role), name_(std::move(name)), source_(new_source()) {
  auto& parts = bus_->parts();
  if (parts.origin.is_inherited()) throw NetworkError(parts.origin.problem("the local bus"));
  const std::scoped_lock lock(parts.counting);
  const bool is_taken =
      role_ == Role::service && std::ranges::any_of(parts.participants, [this](const auto* other) {
        return other->role_ == Role::service && other->name_ == name_;
      });
  if (is_taken) throw NameTaken("a service named " + in_quotes(name_) + " is already on this bus");
  parts.participants.push_back(this);
  const SourceKey key = as_numbers(source_);
  parts.sources.insert(std::ranges::lower_bound(parts.sources, key), key);
}

LocalParticipant::~LocalParticipant() {
  const std::scoped_lock lock(bus_->parts().counting);
  std::erase(bus_->parts().participants, this);
  std::erase(bus_->parts().sources, as_numbers(source_));
}

std::uint64_t LocalParticipant::join_clock(const ClockOfBench& clock, std::uint64_t session) {
  const std::uint64_t thread = number_of_this_thread();
  const std::scoped_lock lock(bus_->parts().joining);
  for (const auto& [joined, its_thread] : bus_->parts().joined_threads) {
    const auto& [its_clock, other] = joined;
    if (its_thread == thread && its_clock == clock && other != session) return other;
  }
  bus_->parts().joined_threads[{clock, session}] = thread;
  return 0;
}

void LocalParticipant::leave_clock(const ClockOfBench& clock, std::uint64_t session) noexcept {
  const std::scoped_lock lock(bus_->parts().joining);
  bus_->parts().joined_threads.erase({clock, session});
}

void LocalParticipant::leave_clocks(std::uint64_t session) noexcept {
  const std::scoped_lock lock(bus_->parts().joining);
  std::erase_if(bus_->parts().joined_threads, [session](const auto& joined) {
    return joined.first.second == session;
  });
}

std::unique_ptr<SampleWriter> LocalParticipant::make_writer(TopicId topic,
                                                            SampleWriter::Observer observer) {
  return std::make_unique<LocalWriter>(bus_, source_, topic, std::move(observer));
}

std::unique_ptr<SampleReader> LocalParticipant::make_reader(TopicId topic, SampleHandler handler) {
  return std::make_unique<LocalReader>(bus_, source_, topic, std::move(handler));
}

std::vector<OtherParticipant> LocalParticipant::others(std::string_view beginning) const {
  const std::scoped_lock lock(bus_->parts().counting);
  std::vector<OtherParticipant> others;
  for (const LocalParticipant* const other : bus_->parts().participants) {
    if (other == this || is_ignored(role_, other->role_)) continue;
    if (!other->name_.starts_with(beginning)) continue;
    others.push_back({.name = other->name_, .source = other->source_});
  }
  return others;
}

bool LocalParticipant::is_certain(const Source& source) const noexcept {
  const std::scoped_lock lock(bus_->parts().counting);
  return std::ranges::binary_search(bus_->parts().sources, as_numbers(source));
}

// ---- writer ------------------------------------------------------------------------------------

LocalWriter::LocalWriter(std::shared_ptr<LocalBus> bus, const Source& source, TopicId topic,
                         Observer observer)
    : bus_(std::move(bus)),
      id_(new_endpoint(source)),
      topic_(topic),
      observer_(std::move(observer)) {
  auto& parts = bus_->parts();
  const std::scoped_lock lock(parts.members);
  auto& writers = parts.writers[place_of(topic_)];
  writers.reserve(writers.size() + 1);
  for (LocalReader* const reader : parts.readers[place_of(topic_)]) {
    matches_.add(reader->id());
    reader->matches().add(id_);
  }
  if (matches_.count() != 0) report_matches();
  writers.push_back(this);  // last, so that a failed construction leaves no pointer behind
}

LocalWriter::~LocalWriter() {
  auto& parts = bus_->parts();
  const std::scoped_lock lock(parts.members);
  std::erase(parts.writers[place_of(topic_)], this);
  for (LocalReader* const reader : parts.readers[place_of(topic_)]) reader->matches().remove(id_);
}

void LocalWriter::match(const LocalReader& reader) {
  matches_.add(reader.id());
  report_matches();
}

void LocalWriter::unmatch(const LocalReader& reader) {
  matches_.remove(reader.id());
  report_matches();
}

void LocalWriter::report_matches() const {
  if (observer_) observer_(matches_.sources());
}

bool LocalWriter::write(std::span<const std::byte> sample) noexcept {
  try {
    const std::shared_lock lock(bus_->parts().members);
    const std::scoped_lock writing(writing_);
    if (traits_of(topic_).transient_local) keep(sample);
    for (LocalReader* const reader : bus_->parts().readers[place_of(topic_)]) {
      reader->take(sample, id_.source);
    }
    return true;
  } catch (...) {  // out of memory
    return false;
  }
}

void LocalWriter::keep(std::span<const std::byte> sample) {
  auto& kept = history_[support_of(topic_).key(sample)];
  if (kept.size() == static_cast<std::size_t>(traits_of(topic_).depth)) kept.pop_front();
  kept.emplace_back(sample.begin(), sample.end());
}

void LocalWriter::replay(LocalReader& reader) const {
  for (const auto& [key, samples] : history_) {
    for (const auto& sample : samples) reader.take(sample, id_.source);
  }
}

// ---- reader ------------------------------------------------------------------------------------

LocalReader::LocalReader(std::shared_ptr<LocalBus> bus, const Source& source, TopicId topic,
                         SampleHandler handler)
    : bus_(std::move(bus)), id_(new_endpoint(source)), topic_(topic), handler_(std::move(handler)) {
  auto& parts = bus_->parts();
  const std::scoped_lock lock(parts.members);
  auto& readers = parts.readers[place_of(topic_)];
  readers.reserve(readers.size() + 1);
  for (LocalWriter* const writer : parts.writers[place_of(topic_)]) {
    matches_.add(writer->id());
    writer->match(*this);
    writer->replay(*this);
  }
  readers.push_back(this);  // last, so that a failed construction leaves no pointer behind
}

LocalReader::~LocalReader() {
  auto& parts = bus_->parts();
  const std::scoped_lock lock(parts.members);
  std::erase(parts.readers[place_of(topic_)], this);
  for (LocalWriter* const writer : parts.writers[place_of(topic_)]) writer->unmatch(*this);
}

void LocalReader::take(std::span<const std::byte> sample, const Source& source) {
  const std::scoped_lock lock(taking_);
  try {
    handler_.take(sample);
  } catch (...) {  // out of memory: dropped for this reader only
    return;
  }
  handler_.deliver(source);
}

}  // namespace vdrive::wire
