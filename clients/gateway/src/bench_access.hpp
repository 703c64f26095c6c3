// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "directory.hpp"
#include "jogs.hpp"
#include "services.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace vdrive::gateway {

/// The session of the connection that holds control, in which it commands the benches.
struct HeldSession {
  std::uint64_t id = 0;
  SessionPointer session;      ///< for calls
  std::shared_ptr<Jogs> jogs;  ///< jogs axes in this session
};

/// Parameters for a client, and what went wrong.
struct ParameterAnswer {
  std::vector<Parameter> parameters;
  std::vector<std::string> complaints;  ///< each is a sentence
};

/// The hub's access to the benches, for its parts. Thread-safe; all functions except end() wait for
/// the benches.
class BenchAccess {
 public:
  virtual ~BenchAccess() = default;

  /// Opens the session of a connection that takes control. @throws std::exception
  [[nodiscard]] virtual HeldSession open() = 0;

  /// Ends the session without waiting.
  /// @param is_graceful true: its jogs stop, and its axes are released in their present state;
  ///        false: it stops sending, and the axes react per 6007h
  virtual void end(HeldSession held, bool is_graceful) = 0;

  /// Carries out a service call.
  /// @param own the session of the connection; null if it does not hold control
  /// @throws ProtocolError when the request is wrong
  [[nodiscard]] virtual CallAnswer call(const ServiceRow& row, const SessionPointer& own,
                                        const Json& request) = 0;

  [[nodiscard]] virtual ParameterAnswer read(const BenchList& benches,
                                             const std::vector<std::string>& names) = 0;

  /// @param own the session of the connection
  [[nodiscard]] virtual ParameterAnswer write(const SessionPointer& own, const BenchList& benches,
                                              const std::vector<ParameterChange>& changes) = 0;
};

}  // namespace vdrive::gateway
