// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "seam/byte_ring.hpp"
#include "seam/doorbell.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/topics.hpp"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::service {

/// The rings of the seam between engine and wire. The first three carry the engine's output.
enum class Lane : std::uint8_t {
  status,       ///< status frames and samples of axes
  replies,      ///< answers to requests and command frames
  reports,      ///< descriptions, states, parameters, events, names of sessions
  arrivals,     ///< command frames and requests
  turned_away,  ///< beginnings of samples that found `arrivals` full
  notices,      ///< states of other services with this bench number, names of sessions
};

inline constexpr std::size_t kLanes = 6;

/// The state of the wire; written by the wire.
enum class WireState : std::uint32_t {
  none,      ///< no wire runs
  starting,  ///< the wire of `WireControl::generation` is not ready yet
  running,
  failed,  ///< it could not start; the reason is in `WireControl::error`
};

/// A list of participants that one side writes and the other reads, without waiting.
class SharedSources {
 public:
  static constexpr std::size_t kCapacity = 1'024;

  /// Empties the list. Only while nobody writes it.
  void reset() noexcept;

  /// Writes the list. One thread at a time. Sources beyond the capacity are left out.
  void show(const std::vector<wire::Source>& sources) noexcept;

  /// @return whether the list contains `source`; true while the list is being changed.
  [[nodiscard]] bool may_contain(const wire::Source& source) const noexcept;

 private:
  using Words = std::array<std::atomic<std::uint32_t>, 3>;

  std::atomic<std::uint32_t> version_{0};  ///< odd while the list is being changed
  std::atomic<std::uint32_t> count_{0};
  std::array<Words, kCapacity> words_{};
};

/// The control block: the part of the region that is not a ring. Each member is written by one side
/// only. All members are plain numbers, because either process may end at any instruction.
struct WireControl {
  std::atomic<std::uint64_t> layout{0};  ///< kLayout

  // The engine writes.
  std::atomic<std::uint32_t> generation{0};  ///< wires started so far
  std::atomic<std::uint32_t> stop{0};        ///< not 0: send what is queued, announce the end
  std::atomic<std::uint32_t> settings_size{0};
  std::array<std::uint8_t, 16'384> settings{};  ///< WireSettings in MessagePack

  // The wire writes.
  std::atomic<WireState> state{WireState::none};
  std::atomic<std::uint32_t> running_generation{0};  ///< the generation of `source`
  wire::Source source;                               ///< of the present or last participant
  wire::Source prober;                               ///< of the participant that probes it
  std::array<char, 2'048> error{};
  std::array<std::atomic<std::uint32_t>, wire::kTopics.size()> matched{};
  SharedSources readers;                        ///< of `reply`
  std::atomic<bool> is_state_requested{false};  ///< a new reader waits for a bench_state
  std::atomic<std::int64_t> running_since{0};   ///< monotonic [ns]
  std::atomic<std::uint64_t> pump_beats{0};     ///< rounds that every pump has completed
  std::atomic<std::uint64_t> probe_beats{0};    ///< probes that arrived
  std::atomic<std::uint64_t> resident{0};       ///< memory of the process [bytes]
  std::atomic<std::uint64_t> sent{0};           ///< samples that the library accepted
  std::atomic<std::uint64_t> not_sent{0};       ///< samples that the library did not accept
  std::atomic<std::uint64_t> undelivered{0};    ///< answers whose reader was not found in time
  std::atomic<std::uint64_t> datagrams_dropped{
      0};                                   ///< datagrams that the guards of all wires dropped
  std::atomic<std::uint64_t> overflows{0};  ///< arrivals that found their ring full
  std::atomic<std::uint32_t> finished{0};   ///< after `stop`: everything has been sent

  BellState status_bell;   ///< wakes the pump of `status`
  BellState reports_bell;  ///< wakes the pump of `replies` and `reports`
  BellState arrivals_bell;
  std::array<RingPositions, kLanes> positions{};
};

struct WireSettings {
  wire::NetworkSettings network;
  std::uint32_t bench = 1;
  std::string log_level = "info";
  /// The size of Lane::status, a power of two [bytes]. The wire derives it from the region's size.
  std::size_t status_room = std::size_t{1} << 20U;
};

/// The memory shared by engine and wire: the control block and the rings. Threads of one process
/// use it in the same way as two processes.
class WireRegion {
 public:
  enum class Sharing : std::uint8_t {
    by_descriptor,  ///< a child process can map it
    none,           ///< memory of this process only; no descriptor
  };

  /// @throws std::system_error if the kernel provides no memory
  explicit WireRegion(const WireSettings& settings, Sharing sharing = Sharing::by_descriptor);

  /// Maps the region of an inherited descriptor.
  /// @throws std::system_error; std::runtime_error if it is not a region of this version
  static WireRegion attach(int descriptor);

  ~WireRegion();
  WireRegion(WireRegion&& other) noexcept;
  WireRegion& operator=(WireRegion&&) = delete;
  WireRegion(const WireRegion&) = delete;
  WireRegion& operator=(const WireRegion&) = delete;

  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }

  /// For the engine, while no wire runs: repairs whatever the last one may have overwritten.
  void prepare_for(std::uint32_t generation) const noexcept;

  [[nodiscard]] WireControl& control() const noexcept { return *control_; }

  /// @return one side's end of a lane; each side calls this once.
  [[nodiscard]] ByteRing ring(Lane lane) const noexcept;

  /// @throws std::runtime_error if they cannot be read
  [[nodiscard]] WireSettings settings() const;

 private:
  WireRegion(int descriptor, std::span<std::byte> memory, std::size_t status_room) noexcept;

  int descriptor_ = -1;
  std::vector<std::uint8_t> settings_;  ///< only in the engine, which created the region
  std::size_t status_room_ = 0;
  std::span<std::byte> memory_;
  WireControl* control_ = nullptr;
};

}  // namespace vdrive::service
