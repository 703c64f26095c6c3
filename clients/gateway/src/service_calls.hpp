// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client_table.hpp"
#include "control_desk.hpp"
#include "server_calls.hpp"
#include "services.hpp"
#include "worker.hpp"

#include <functional>
#include <utility>

namespace vdrive::gateway {

/// The calls of services: who may make them, which thread carries them out, and their answers. Of
/// the server's thread.
class ServiceCalls {
 public:
  /// Carries a service out, and waits. Any thread.
  /// @param own the session of the connection; null when it does not hold control
  /// @throws ProtocolError when the request is wrong
  using CarryOut = std::function<CallAnswer(const ServiceRow& row, const SessionPointer& own,
                                            const Json& request)>;

  /// @param clients outlives this, as `control` does
  ServiceCalls(ServerCalls server, ClientTable& clients, ControlDesk& control, CarryOut carry_out)
      : server_(std::move(server)),
        clients_(clients),
        control_(control),
        carry_out_(std::move(carry_out)) {}

  /// @param id of an open connection
  void handle(ConnectionId id, const CallService& call);

 private:
  using Answer = Jogs::Answer;

  void route(ConnectionId id, const ServiceRow& row, Json request, const Answer& answer);
  void jog(const Json& request, const Answer& answer);
  void carry_out(ConnectionId id, const ServiceRow& row, Json request, const Answer& answer);

  const ServerCalls server_;
  ClientTable& clients_;
  ControlDesk& control_;
  const CarryOut carry_out_;
  bridge::Worker stops_;  ///< halts and quick stops of everybody; last: its jobs use what is above
};

}  // namespace vdrive::gateway
