// SPDX-License-Identifier: Apache-2.0
#include "session/session_core.hpp"

#include "vdrive/text.hpp"
#include "vdrive/wire/ports.hpp"

#include <charconv>
#include <chrono>
#include <cstdlib>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

namespace vdrive::client {
namespace {

// A bench publishes its state every 50 ms, in every clock mode.
constexpr std::chrono::milliseconds kShortestSilence{50};

// Well below `kShortestSilence` and the least time-out of a bench's watchdog.
constexpr std::chrono::milliseconds kLongestCoalescing{20};

const SessionOptions& checked(const SessionOptions& options) {
  if (options.silence < kShortestSilence) {
    throw std::runtime_error(
        "silence = " + std::to_string(options.silence.count()) +
        " ms, the time without samples after which a service is lost: must be 50 ms or more");
  }
  const auto coalescing = options.receive_coalescing;
  if (coalescing.count() < 0 || coalescing > kLongestCoalescing) {
    throw std::runtime_error("receive_coalescing = " + std::to_string(coalescing.count()) +
                             " ms, the time between two receptions: must be 0 to 20 ms");
  }
  return options;
}

std::uint64_t random_session() {
  std::random_device device;
  std::uint64_t number = 0;
  while (number == 0) number = (std::uint64_t{device()} << 32U) | device();
  return number;
}

wire::NetworkSettings settings_of(const SessionOptions& options) {
  return {.domain = options.domain.value_or(0),
          .takes_default_domain = !options.domain,
          .interfaces = options.interfaces,
          .peers = options.peers,
          .discovery_servers = options.discovery_servers,
          .shared_memory = false,
          .security = options.security,
          .role = wire::Role::client,
          .bus = options.bus,
          .receive_coalescing = options.receive_coalescing};
}

}  // namespace

std::uint32_t default_domain() {
  return wire::default_domain();
}

SessionCore::SessionCore(const SessionOptions& chosen)
    : options(checked(chosen)),
      id(random_session()),
      held_axes(id),
      participant(wire::make_participant(settings_of(options), "vdrive client")),
      discovery(*participant, options, wakeup),
      names(*participant, id, options.program, discovery, wakeup),
      links(*participant, id, discovery, held_axes, history, wakeup, failure),
      exchange(id, links, held_axes, history),
      control(options.keep_alive, exchange, held_axes, history, links, names),
      clocks(id, exchange, held_axes, discovery, wakeup, *participant),
      stream(*participant, discovery, links, wakeup),
      observer(discovery, links, exchange, clocks, stream),
      watcher(discovery, stream, failure, reports),
      events(*participant, discovery, observer, failure, reports),
      refusals(links, failure, reports),
      statuses(discovery, stream, observer, failure),
      status_reports(reports) {
  wakeup.work_with([this](std::uint32_t bench) {
    return participant->run_local_work(bench);
  });
}

void SessionCore::end() {
  if (!discovery.check_process()) return;
  // The reports to the program end first, because a report may start a call; the links close last,
  // because the release needs them.
  reports.end();
  clocks.leave_all();
  control.end();
  names.finish();
  links.close();
}

void SessionCore::abandon() noexcept {
  if (!discovery.check_process()) return;
  // The links close first, so that a call ended by the interrupt sends nothing more.
  links.close();
  clocks.abandon();
  wakeup.interrupt();
}

Result<std::vector<std::uint16_t>> numbers_of(std::span<const AxisId> axes) {
  std::vector<std::uint16_t> numbers;
  for (const AxisId& id : axes) {
    if (id.bench != axes.front().bench) {
      return Outcome::not_found("axes " + to_string(axes.front()) + " and " + to_string(id) +
                                " are not on one bench");
    }
    numbers.push_back(id.axis);
  }
  if (numbers.empty()) return Outcome::not_found("no axis given");
  return numbers;
}

}  // namespace vdrive::client
