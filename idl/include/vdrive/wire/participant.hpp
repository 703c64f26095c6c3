// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/guard.hpp"
#include "vdrive/wire/presence.hpp"
#include "vdrive/wire/sample_reader.hpp"
#include "vdrive/wire/sample_writer.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive/wire/topics.hpp"

#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdrive::wire {

class LocalBus;  ///< vdrive/wire/local_bus.hpp

/// What a participant is for. A client ignores other clients, so that the joins and leaves of many
/// clients cost nothing.
enum class Role : std::uint8_t { other, service, client };

/// Where a participant may be reached, and how it finds others. The default is loopback UDP only,
/// with multicast. With a local bus there is no network, and only `bus` and `role` count.
struct NetworkSettings {
  std::uint32_t domain = 0;               ///< DDS domain, 0 to 232
  bool takes_default_domain = false;      ///< `domain` is that of default_domain() in ports.hpp
  std::vector<std::string> interfaces{};  ///< in the networks to use: own addresses, or names such
                                          ///< as eth0; empty = loopback only
  std::vector<std::string> peers{};  ///< addresses or names of hosts asked in addition to multicast
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

/// What became of work that a bench leaves to the threads of its clients.
enum class LocalWork : std::uint8_t {
  none,       ///< there was none
  done,       ///< this thread has done some
  elsewhere,  ///< another thread does it, or leaves it to whoever calls again
};

/// The clock of a bench: of one run of it.
struct ClockOfBench {
  std::uint32_t bench = 0;
  std::uint64_t incarnation = 0;

  friend auto operator<=>(const ClockOfBench&, const ClockOfBench&) = default;
};

/// A program's place among those that exchange the messages of vdrive: a DDS domain participant, or
/// a place on the local bus of this process. Must outlive its writers and readers.
/// Over DDS it shows no type objects, and announces itself every 100 ms with a lease of 600 s (2 s
/// in the closed mode and to a discovery server); its guard removes participants of vdrive
/// after 2.5 s of silence, others after the lease that they announce.
class Participant {
 public:
  Participant() = default;
  virtual ~Participant() = default;
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// @throws NotPermitted when the permissions of a closed participant do not name the topic;
  ///         NetworkError when DDS refuses topic, publisher or writer.
  [[nodiscard]] virtual std::unique_ptr<SampleWriter> make_writer(
      TopicId topic, SampleWriter::Observer observer = nullptr) = 0;

  /// @throws NetworkError when DDS refuses topic, subscriber or reader.
  [[nodiscard]] virtual std::unique_ptr<SampleReader> make_reader(TopicId topic,
                                                                  SampleHandler handler) = 0;

  /// @return where it is, in words for people: "on this bus", or "on domain 7".
  [[nodiscard]] virtual std::string place() const = 0;

  /// @return the DDS domain; 0 on a local bus.
  [[nodiscard]] virtual std::uint32_t domain() const noexcept { return 0; }

  /// @return whether it has DDS Security: it meets participants of its closed mode only.
  [[nodiscard]] virtual bool is_closed() const noexcept { return false; }

  /// @return what its messages show as their source.
  [[nodiscard]] virtual Source source() const noexcept = 0;

  /// Makes all participants read its announcement again. The library reads each announcement once:
  /// a participant that had no room for this one would not know it until the announcement changes.
  virtual void announce_again() {}

  /// @return who else is there; lives as long as this participant.
  [[nodiscard]] virtual Presence& presence() noexcept = 0;

  // What a bench of this process asks of the threads of its clients; over DDS nothing.

  /// Does work that a bench leaves to the threads of its clients (LocalBus::WorkPlace). The caller
  /// holds no lock that a handler of a subscription takes.
  virtual LocalWork run_local_work(std::uint32_t /*bench*/) { return LocalWork::none; }

  /// Before a client sends to a bench: one of this process may have to work off first what it has
  /// received. Over DDS the writer waits instead. The caller holds no lock that a handler takes.
  /// @return whether the bench has room; if not, the call has waited for a moment.
  virtual bool make_room(std::uint32_t /*bench*/) { return true; }

  /// Notes that the calling thread joins the clock with this session. Of two sessions on a local
  /// bus that one thread has joined to a clock none could step: the step of one waits for the grant
  /// of the other, and the thread that waits grants nothing. Over DDS each waits for its answer
  /// alone.
  /// @return the session with which this thread has joined the clock already; 0 = none.
  [[nodiscard]] virtual std::uint64_t join_clock(const ClockOfBench& /*clock*/,
                                                 std::uint64_t /*session*/) {
    return 0;
  }

  /// The session has left the clock.
  virtual void leave_clock(const ClockOfBench& /*clock*/, std::uint64_t /*session*/) noexcept {}

  /// The session has left every clock.
  virtual void leave_clocks(std::uint64_t /*session*/) noexcept {}

  /// @return what is in the way of finding others now, each a line for people: a name that does not
  ///         resolve, a discovery server that does not answer.
  [[nodiscard]] virtual std::vector<std::string> troubles() const { return {}; }

  /// @return what the guard has done; all zero without a guard.
  [[nodiscard]] virtual GuardCounts guard_counts() const { return {}; }
};

/// @return a participant on the local bus of `settings`, or else of a DDS domain.
/// @throws NetworkError when the domain is out of range, the security material is not in order,
///         DDS refuses the participant, this program has no DDS library, or the local bus belongs
///         to the process from which this one was forked; NameTaken; what default_domain() throws.
[[nodiscard]] std::unique_ptr<Participant> make_participant(const NetworkSettings& settings,
                                                            const std::string& name);

}  // namespace vdrive::wire
