// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/guard.hpp"
#include "vdrive/wire/presence.hpp"
#include "vdrive/wire/sample_reader.hpp"
#include "vdrive/wire/sample_writer.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive/wire/topics.hpp"

#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdrive::wire {

class LocalBus;  ///< vdrive/wire/local_bus.hpp

/// The role of a participant. A client ignores other clients, so that many clients joining and
/// leaving cost it nothing.
enum class Role : std::uint8_t { other, service, client };

/// How a participant can be reached and how it finds others. The default is loopback UDP only, with
/// multicast. On a local bus there is no network, and only `bus` and `role` are used.
struct NetworkSettings {
  std::uint32_t domain = 0;               ///< DDS domain, 0 to 232
  bool takes_default_domain = false;      ///< `domain` comes from default_domain() in ports.hpp
  std::vector<std::string> interfaces{};  ///< to use: own addresses, or names such as eth0;
                                          ///< empty = loopback only
  std::vector<std::string> peers{};  ///< addresses or host names to query in addition to multicast
  std::vector<std::string>
      discovery_servers{};     ///< such as 10.0.0.9:11811, instead of multicast; first = id 0
  bool shared_memory = false;  ///< opt-in: killed processes leave segments behind
  std::string security{};      ///< directory with the material of the closed mode; empty = open
  Role role =
      Role::other;         ///< client: ignores participants named "vdrive client" or "vdrive probe"
  bool guard = true;       ///< false lets tests see the library without the guard
  GuardSink guard_sink{};  ///< receives each refusal of the guard
  std::string place{};     ///< of a service: process and host, shown to others (DDS user data)
  std::shared_ptr<LocalBus> bus{};  ///< of this process; null = DDS
  /// An idle receiver that got a datagram sleeps up to this long and then takes all that arrived:
  /// fewer wakeups, later answers. Needs the guard; 0 = receives immediately.
  std::chrono::milliseconds receive_coalescing{};
};

/// Receive buffer that a client requests for each of its sockets, limited by net.core.rmem_max
/// [bytes]. The kernel reserves twice as much, including its overhead per datagram: enough for 60
/// ms of the status of 4,096 axes at 1 kHz. Only waiting data takes up memory.
inline constexpr std::uint32_t kReceiveBufferOfClient = 16U * 1024U * 1024U;

/// DDS could not be set up; the message names the entity and the setting.
class NetworkError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Another service on the local bus already has this name.
class NameTaken : public NetworkError {
 public:
  using NetworkError::NetworkError;
};

/// The permissions of this participant's identity do not include what was requested.
class NotPermitted : public NetworkError {
 public:
  using NetworkError::NetworkError;
};

/// Result of running work that a bench leaves to the threads of its clients.
enum class LocalWork : std::uint8_t {
  none,       ///< there was no work
  done,       ///< this thread did some work
  elsewhere,  ///< another thread is doing it, but may stop before all is done: call again soon
};

/// Identifies the clock of one run of a bench.
struct ClockOfBench {
  std::uint32_t bench = 0;
  std::uint64_t incarnation = 0;

  friend auto operator<=>(const ClockOfBench&, const ClockOfBench&) = default;
};

/// A participant in the exchange of vdrive messages: a DDS domain participant, or a place on the
/// local bus of this process. Must outlive its writers and readers.
/// Over DDS it announces no type objects. It announces itself every 100 ms with a lease of 600 s (2
/// s in the closed mode and to a discovery server). Its guard removes vdrive participants after 2.5
/// s of silence, others after the lease that they announce.
class Participant {
 public:
  Participant() = default;
  virtual ~Participant() = default;
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// @throws NotPermitted when the permissions of a closed participant do not include the topic;
  ///         NetworkError when DDS refuses topic, publisher or writer.
  [[nodiscard]] virtual std::unique_ptr<SampleWriter> make_writer(
      TopicId topic, SampleWriter::Observer observer = nullptr) = 0;

  /// @throws NetworkError when DDS refuses topic, subscriber or reader.
  [[nodiscard]] virtual std::unique_ptr<SampleReader> make_reader(TopicId topic,
                                                                  SampleHandler handler) = 0;

  /// @return where this participant is, for messages: "on this bus" or "on domain 7".
  [[nodiscard]] virtual std::string place() const = 0;

  /// @return the DDS domain; 0 on a local bus.
  [[nodiscard]] virtual std::uint32_t domain() const noexcept { return 0; }

  /// @return whether this participant uses DDS Security and so exchanges data only with
  ///         participants of the same closed network.
  [[nodiscard]] virtual bool is_closed() const noexcept { return false; }

  /// @return the source that receivers of its messages see.
  [[nodiscard]] virtual Source source() const noexcept = 0;

  /// Makes all participants read its announcement again. The library reads each announcement only
  /// once, so a participant that had no room for this one learns of it only when the announcement
  /// changes.
  virtual void announce_again() {}

  /// @return the presence of other participants; lives as long as this participant.
  [[nodiscard]] virtual Presence& presence() noexcept = 0;

  // Work that a bench of this process leaves to the threads of its clients; none over DDS.

  /// Does work that a bench leaves to the threads of its clients (LocalBus::WorkPlace). The caller
  /// must not hold a lock that a handler of a subscription takes.
  virtual LocalWork run_local_work(std::uint32_t /*bench*/) { return LocalWork::none; }

  /// Called before a client sends to a bench. A bench of this process may first have to process
  /// what it has received; over DDS the writer waits instead. The caller must not hold a lock that
  /// a handler takes.
  /// @return whether the bench has room; if not, the call has waited briefly.
  virtual bool make_room(std::uint32_t /*bench*/) { return true; }

  /// Records that the calling thread joins the clock with this session. If one thread joined two
  /// sessions on a local bus to the same clock, neither could step: the step of one waits for the
  /// grant of the other, and a waiting thread grants nothing. Over DDS each session waits only for
  /// its own answer.
  /// @return the session with which this thread has already joined the clock; 0 = none.
  [[nodiscard]] virtual std::uint64_t join_clock(const ClockOfBench& /*clock*/,
                                                 std::uint64_t /*session*/) {
    return 0;
  }

  /// Records that the session has left the clock.
  virtual void leave_clock(const ClockOfBench& /*clock*/, std::uint64_t /*session*/) noexcept {}

  /// Records that the session has left every clock.
  virtual void leave_clocks(std::uint64_t /*session*/) noexcept {}

  /// @return what prevents finding others at present, one line each: a name that does not resolve,
  ///         a discovery server that does not answer.
  [[nodiscard]] virtual std::vector<std::string> troubles() const { return {}; }

  /// @return the counts of the guard; all zero without a guard.
  [[nodiscard]] virtual GuardCounts guard_counts() const { return {}; }
};

/// @return a participant on the local bus of `settings` if it has one, otherwise in a DDS domain.
/// @throws NetworkError when the domain is out of range, the security material is invalid, DDS
///         refuses the participant, this program has no DDS library, or the local bus belongs to
///         the process from which this one was forked; NameTaken; the exceptions of
///         default_domain().
[[nodiscard]] std::unique_ptr<Participant> make_participant(const NetworkSettings& settings,
                                                            const std::string& name);

}  // namespace vdrive::wire
