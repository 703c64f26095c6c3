// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/guard.hpp"
#include "vdrive/wire/source.hpp"

#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {

class Backend;   ///< known inside the wire room only
class LocalBus;  ///< vdrive/wire/local_bus.hpp

/// What a participant is for. A client ignores other clients, so that the joins and leaves of many
/// clients cost nothing.
enum class Role : std::uint8_t { other, service, client };

/// Where a participant may be reached, and how it finds others. The default is loopback UDP only,
/// with multicast. With a local bus there is no network, and only `bus` and `role` count.
struct NetworkSettings {
  std::uint32_t domain = 0;           ///< DDS domain, 0 to 232
  bool takes_default_domain = false;  ///< `domain` is that of default_domain() in ports.hpp
  std::vector<std::string>
      interfaces{};  ///< own addresses in the networks to use; empty = loopback only
  std::vector<std::string> peers{};  ///< hosts asked in addition to multicast
  std::vector<std::string>
      discovery_servers{};     ///< such as 10.0.0.9:11811, instead of multicast; first = id 0
  bool shared_memory = false;  ///< opt-in: killed processes leave segments behind
  std::string security{};      ///< directory of the closed mode's material; empty = open
  Role role =
      Role::other;         ///< client: ignores participants named "vdrive client" or "vdrive probe"
  bool guard = true;       ///< false shows in tests what the library does without it
  GuardSink guard_sink{};  ///< receives each refusal of the guard
  std::string place{};     ///< of a service: process and host, shown to others (user data of DDS)
  std::shared_ptr<LocalBus> bus{};  ///< of this process; nothing = DDS
};

/// What a client asks the kernel for as the receive buffer of each of its sockets, as far as
/// net.core.rmem_max permits [bytes]. The kernel holds twice as much, counted with what a datagram
/// takes beside its bytes: 60 ms of the status of 4,096 axes at 1 kHz. Memory is taken only for
/// what waits there.
inline constexpr std::uint32_t kReceiveBufferOfClient = 16U * 1024U * 1024U;

/// DDS could not be set up; the message names the entity and the setting.
class NetworkError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Another service on the local bus has this name.
class NameTaken : public NetworkError {
 public:
  using NetworkError::NetworkError;
};

/// The permissions of this participant's identity do not include what was asked for.
class NotPermitted : public NetworkError {
 public:
  using NetworkError::NetworkError;
};

/// What another participant announces of itself.
struct OtherParticipant {
  std::string name;
  Source source;
  bool is_closed = false;  ///< it has DDS Security: only participants of its closed mode meet it
  std::string place{};  ///< NetworkSettings::place; anything of a stranger, empty where it has none
};

/// What became of work that a bench leaves to the threads of its clients.
enum class LocalWork : std::uint8_t {
  none,       ///< there was none
  done,       ///< this thread has done some
  elsewhere,  ///< another thread does it, or leaves it to those who come again
};

/// The clock of a bench: of one run of it.
struct ClockOfBench {
  std::uint32_t bench = 0;
  std::uint64_t incarnation = 0;

  friend auto operator<=>(const ClockOfBench&, const ClockOfBench&) = default;
};

/// A program's place among those that exchange the messages of vdrive: a DDS domain participant, or
/// a place on the local bus of this process. Must outlive its publications and subscriptions.
/// Over DDS it shows no type objects, and announces itself every 100 ms with a lease of 600 s (2 s
/// to a discovery server); its guard removes participants of vdrive after 2.5 s of silence, others
/// after the lease that they announce.
class Participant {
 public:
  /// @throws NetworkError when the domain is out of range, the security material is not in order,
  ///         DDS refuses the participant, this program has no DDS library, or the local bus belongs
  ///         to the process from which this one was forked; NameTaken; what default_domain()
  ///         throws.
  Participant(const NetworkSettings& settings, const std::string& name);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// @return where it is, in words for people: "on this bus", or "on domain 7".
  [[nodiscard]] std::string place() const;

  /// @return the DDS domain; 0 on a local bus.
  [[nodiscard]] std::uint32_t domain() const noexcept;

  /// @return whether it has DDS Security: it meets participants of its closed mode only.
  [[nodiscard]] bool is_closed() const noexcept;

  /// @return what its messages show as their source.
  [[nodiscard]] Source source() const noexcept;

  /// Makes all participants read its announcement again. The library reads each announcement once:
  /// a participant that had no room for this one would not know it until the announcement changes.
  void announce_again();

  /// @return the other participants that are known now and have a name with this beginning. They
  ///         are known before their writers and readers are.
  [[nodiscard]] std::vector<OtherParticipant> others(std::string_view beginning = "") const;

  /// @return whether `others` are all that there are, each as long as it lives. Over a network a
  ///         participant that is there may not be known yet, and one that has died still is.
  [[nodiscard]] bool knows_who_is_there() const noexcept;

  /// @return whether the participant `source` is there, where `knows_who_is_there`; otherwise
  /// false.
  [[nodiscard]] bool has(const Source& source) const noexcept;

  /// Does work that a bench of this process leaves to the threads of its clients
  /// (LocalBus::WorkPlace). Over DDS there is none. The caller holds no lock that a handler of a
  /// subscription takes.
  LocalWork run_local_work(std::uint32_t bench);

  /// Before a client sends to a bench: one of this process may have to work off first what it has
  /// received. Over DDS the writer waits instead. The caller holds no lock that a handler takes.
  /// @return whether the bench has room; if not, the call has waited for a moment.
  bool make_room(std::uint32_t bench);

  /// Notes that the calling thread joins the clock with this session. Of two sessions on a local
  /// bus that one thread has joined to a clock none could step: the step of one waits for the grant
  /// of the other, and the thread that waits grants nothing. Over DDS each waits for its answer
  /// alone.
  /// @return the session with which this thread has joined the clock already; 0 = none.
  [[nodiscard]] std::uint64_t join_clock(const ClockOfBench& clock, std::uint64_t session);

  /// The session has left the clock.
  void leave_clock(const ClockOfBench& clock, std::uint64_t session) noexcept;

  /// The session has left every clock.
  void leave_clocks(std::uint64_t session) noexcept;

  /// @return what the guard has done; all zero without a guard.
  [[nodiscard]] GuardCounts guard_counts() const;

  [[nodiscard]] Backend& backend() noexcept { return *backend_; }

 private:
  std::unique_ptr<Backend> backend_;
};

}  // namespace vdrive::wire
