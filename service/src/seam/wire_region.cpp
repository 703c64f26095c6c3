// SPDX-License-Identifier: Apache-2.0
#include "seam/wire_region.hpp"

#include "base/system_failure.hpp"

#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <new>
#include <numeric>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace vdrive::service {
namespace {

constexpr std::uint64_t kLayout = 0x7664'7269'7665'0003;  // "vdrive", version 3
constexpr std::size_t kKibi = 1'024;
constexpr std::size_t kMebi = kKibi * kKibi;

/// The sizes of all lanes after `status`, whose size depends on the bench. They hold: all answers
/// to a full inbox; the descriptions and parameters of 16,384 axes at the same time; the arrivals,
/// arrivals turned away and notices.
constexpr std::array<std::size_t, kLanes - 1> kFixedSizes{8 * kMebi, 8 * kMebi, 4 * kMebi,
                                                          64 * kKibi, 64 * kKibi};

constexpr std::size_t kPage = 4'096;
constexpr std::size_t kControlSize = (sizeof(WireControl) + kPage - 1) / kPage * kPage;

constexpr std::size_t kFixedSize =
    kControlSize + std::accumulate(kFixedSizes.begin(), kFixedSizes.end(), std::size_t{0});

constexpr std::size_t size_of(Lane lane, std::size_t status_room) noexcept {
  return lane == Lane::status ? status_room : kFixedSizes[static_cast<std::size_t>(lane) - 1];
}

constexpr std::size_t offset_of(Lane lane, std::size_t status_room) noexcept {
  std::size_t offset = kControlSize;
  for (std::size_t before = 0; before < static_cast<std::size_t>(lane); ++before) {
    offset += size_of(static_cast<Lane>(before), status_room);
  }
  return offset;
}

/// MessagePack and not JSON, because a path may contain arbitrary bytes, which JSON refuses.
std::vector<std::uint8_t> packed(const WireSettings& settings) {
  const auto& network = settings.network;
  return nlohmann::json::to_msgpack({{"bench", settings.bench},
                                     {"log_level", settings.log_level},
                                     {"domain", network.domain},
                                     {"interfaces", network.interfaces},
                                     {"peers", network.peers},
                                     {"discovery_servers", network.discovery_servers},
                                     {"shared_memory", network.shared_memory},
                                     {"security", network.security},
                                     {"place", network.place},
                                     {"guard", network.guard}});
}

WireSettings unpacked(std::span<const std::uint8_t> bytes) {
  const auto json = nlohmann::json::from_msgpack(bytes.begin(), bytes.end());
  WireSettings settings;
  json.at("bench").get_to(settings.bench);
  json.at("log_level").get_to(settings.log_level);
  json.at("domain").get_to(settings.network.domain);
  json.at("interfaces").get_to(settings.network.interfaces);
  json.at("peers").get_to(settings.network.peers);
  json.at("discovery_servers").get_to(settings.network.discovery_servers);
  json.at("shared_memory").get_to(settings.network.shared_memory);
  json.at("security").get_to(settings.network.security);
  json.at("place").get_to(settings.network.place);
  json.at("guard").get_to(settings.network.guard);
  return settings;
}

/// @param descriptor -1 for memory of this process only
std::span<std::byte> map(int descriptor, std::size_t size) {
  // MAP_NORESERVE for the reason given at Pages.
  const int flags = descriptor < 0 ? MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE : MAP_SHARED;
  // MAP_FAILED is a cast of -1.
  void* const memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, flags, descriptor, 0);
  if (memory == MAP_FAILED) {  // NOLINT(*-cstyle-cast, performance-no-int-to-ptr)
    fail("shared memory of engine and wire");
  }
  return {static_cast<std::byte*>(memory), size};
}

/// @return the descriptor of new memory of this size.
int shared_memory(std::size_t size) {
  const int descriptor = memfd_create("vdrive-wire", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  // Sealed, because a wire that truncated it would kill the engine with SIGBUS.
  if (descriptor < 0 || ftruncate(descriptor, static_cast<off_t>(size)) != 0 ||
      fcntl(descriptor, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) !=
          0) {  // NOLINT(*-vararg)
    fail("shared memory of engine and wire");
  }
  return descriptor;
}

}  // namespace

void SharedSources::show(const std::vector<wire::Source>& sources) noexcept {
  const std::size_t count = std::min(sources.size(), kCapacity);
  version_.fetch_add(1);
  for (std::size_t place = 0; place < count; ++place) {
    const auto words = std::bit_cast<std::array<std::uint32_t, 3>>(sources[place].participant);
    for (std::size_t word = 0; word < words.size(); ++word) words_[place][word].store(words[word]);
  }
  count_.store(static_cast<std::uint32_t>(count));
  version_.fetch_add(1);
}

void SharedSources::reset() noexcept {
  count_.store(0);
  version_.store(0);
}

bool SharedSources::may_contain(const wire::Source& source) const noexcept {
  const std::uint32_t version = version_.load();
  const auto wanted = std::bit_cast<std::array<std::uint32_t, 3>>(source.participant);
  const std::size_t count = std::min<std::size_t>(count_.load(), kCapacity);
  for (std::size_t place = 0; place < count; ++place) {
    if (std::ranges::equal(wanted, words_[place], [](std::uint32_t left, const auto& right) {
          return left == right.load();
        })) {
      return true;
    }
  }
  return version % 2 != 0 || version_.load() != version;
}

WireRegion::WireRegion(const WireSettings& settings, Sharing sharing)
    : settings_(packed(settings)), status_room_(settings.status_room) {
  const std::size_t size = kFixedSize + status_room_;
  if (sharing == Sharing::by_descriptor) descriptor_ = shared_memory(size);
  memory_ = map(descriptor_, size);
  control_ = new (memory_.data()) WireControl;  // NOLINT(*-owning-memory): it lies in the region
  if (settings_.size() > control_->settings.size()) {
    throw std::runtime_error("the network settings have " + std::to_string(settings_.size()) +
                             " bytes; the limit is " + std::to_string(control_->settings.size()));
  }
  prepare_for(0);
}

void WireRegion::prepare_for(std::uint32_t generation) const noexcept {
  std::ranges::copy(settings_, control_->settings.begin());
  control_->settings_size = static_cast<std::uint32_t>(settings_.size());
  control_->stop = 0;
  control_->generation = generation;
  control_->layout = kLayout;
  control_->readers.reset();
  for (auto& matched : control_->matched) matched = 0;
  for (const Lane lane : {Lane::arrivals, Lane::turned_away, Lane::notices}) {
    RingPositions& positions = control_->positions[static_cast<std::size_t>(lane)];
    if (positions.begin > positions.written) positions.begin = 0;
    if (positions.written == positions.read) {
      positions.records_written.store(positions.records_read);
    }
  }
}

WireRegion::WireRegion(int descriptor, std::span<std::byte> memory,
                       std::size_t status_room) noexcept
    : descriptor_(descriptor),
      status_room_(status_room),
      memory_(memory),
      // NOLINTNEXTLINE(*-reinterpret-cast): the other process made it there
      control_(std::launder(reinterpret_cast<WireControl*>(memory.data()))) {}

WireRegion WireRegion::attach(int descriptor) {
  struct stat status {};

  if (fstat(descriptor, &status) != 0) fail("shared memory of engine and wire");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size <= kFixedSize || !std::has_single_bit(size - kFixedSize)) {
    throw std::runtime_error("the shared memory of the engine has a different version (" +
                             std::to_string(size) + " bytes); restart vdrived after an upgrade");
  }
  WireRegion region(descriptor, map(descriptor, size), size - kFixedSize);
  if (region.control().layout != kLayout) {
    throw std::runtime_error(
        "the shared memory of the engine has a different version; restart vdrived after an "
        "upgrade");
  }
  return region;
}

WireRegion::~WireRegion() {
  if (!memory_.empty()) {
    munmap(memory_.data(), memory_.size());
    if (descriptor_ >= 0) close(descriptor_);
  }
}

WireRegion::WireRegion(WireRegion&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      settings_(std::move(other.settings_)),
      status_room_(other.status_room_),
      memory_(std::exchange(other.memory_, {})),
      control_(std::exchange(other.control_, nullptr)) {}

ByteRing WireRegion::ring(Lane lane) const noexcept {
  const auto number = static_cast<std::size_t>(lane);
  return {control_->positions[number],
          memory_.subspan(offset_of(lane, status_room_), size_of(lane, status_room_))};
}

WireSettings WireRegion::settings() const {
  const std::size_t size =
      std::min<std::size_t>(control_->settings_size, control_->settings.size());
  return unpacked(std::span(control_->settings).first(size));
}

}  // namespace vdrive::service
