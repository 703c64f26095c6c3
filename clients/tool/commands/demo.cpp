// SPDX-License-Identifier: Apache-2.0
#include "base/service_program.hpp"
#include "base/usage_error.hpp"
#include "child_process.hpp"
#include "execution/connection.hpp"
#include "gateway_port.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "private_bench.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <random>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using namespace std::chrono_literals;

/// How long the demo leaves an axis alone after a user of the page has acquired or stopped it, or
/// after a fault.
constexpr auto kLeftAlone = 3s;
constexpr auto kPoll = 200ms;
// Long, because the bench has just been started and the machine may be busy.
constexpr auto kStart = 60s;
constexpr auto kEnd = 5s;

/// @return a token that clients of the gateway must send, because other machines may reach it.
std::string random_token() {
  std::random_device source;
  std::uniform_int_distribution<std::size_t> digit(0, 15);
  std::string token;
  for (int i = 0; i < 32; ++i) token += "0123456789abcdef"[digit(source)];
  return token;
}

void rest(const std::stop_token& stop) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any never;
  never.wait_for(lock, stop, kLeftAlone, [] {
    return false;
  });
}

/// @param stroke [UU]
void move_to_and_fro(client::Axis axis, std::int32_t stroke, const std::stop_token& stop) {
  const client::MoveOptions options{.velocity = static_cast<std::uint32_t>(stroke / 2)};
  for (std::int32_t target = stroke; !stop.stop_requested(); target = stroke - target) {
    if (!axis.enable() || !axis.move_to(target, options)) rest(stop);
  }
}

/// @return the address for a local browser, from the first line of a gateway, "vdrive-gateway:
///         http://ADDRESS:PORT/ ..."; empty while there is no such line.
std::string url_in(const std::string& line) {
  const std::size_t begin = line.find("http://");
  const std::size_t end = line.find(' ', begin);
  if (begin == std::string::npos || end == std::string::npos) return {};
  std::string url = line.substr(begin, end - begin);
  constexpr std::string_view kEverywhere = "//0.0.0.0:";
  const std::size_t place = url.find(kEverywhere);
  if (place != std::string::npos) url.replace(place, kEverywhere.size(), "//127.0.0.1:");
  return url;
}

std::string first_line(const std::string& text) {
  return text.empty() ? "the gateway has ended" : text.substr(0, text.find('\n'));
}

/// Starts a bench and the gateway with its page, and moves half of the axes.
struct DemoCommand {
  std::string listen{};

  void declare(Arguments& arguments) {
    arguments.option(
        "--listen", "ADDRESS:PORT", listen,
        "Where the page is served; default: 127.0.0.1:" + std::to_string(bridge::kGatewayPort));
  }

  ExitCode start(const Program& program) const {
    for (const std::string& name : program.options.network_given) {
      if (name != "--domain") {
        throw UsageError(name + " does not apply: the demo runs its bench on this machine");
      }
    }
    const auto gateway = process::find_program("vdrive-gateway");
    if (!gateway) throw UsageError("there is no vdrive-gateway next to this program or in PATH");
    return run_interruptible(program, [&](Interrupt& interrupt) {
      return demonstrate(*gateway, program, interrupt);
    });
  }

 private:
  Outcome demonstrate(const std::string& gateway, const Program& program,
                      Interrupt& interrupt) const {
    process::PrivateBench bench(find_service(""), {"--axes", "4"}, program.options.domain);
    interrupt.arm([&bench] {
      bench.end();
    });
    if (const auto problem = bench.wait_until_ready()) return Outcome::failed(*problem);
    interrupt.disarm();
    const std::string token = random_token();
    const std::string address =
        listen.empty() ? "127.0.0.1:" + std::to_string(bridge::kGatewayPort) : listen;
    process::ChildProcess page({gateway, "--domain", std::to_string(program.options.domain),
                                "--listen", address, "--control", "--token", "/proc/self/fd/0"},
                               {}, {.input = token + "\n"});
    client::SessionOptions options = session_options(program.options);
    options.find_timeout = kStart;
    client::Session session(options);
    interrupt.arm([&session] {
      session.interrupt();
    });
    Outcome outcome = move_until_end(session, bench, page, [&](const std::string& url) {
      program.terminal.print("vdrive: open " + url + "?token=" + token);
    });
    interrupt.disarm();
    page.stop(kEnd);
    return outcome;
  }

  /// @return which of the programs has ended, or an interrupt.
  static Outcome move_until_end(client::Session& session, process::PrivateBench& bench,
                                process::ChildProcess& page,
                                const std::function<void(const std::string&)>& tell) {
    const auto x = session.axis("1.1");
    if (!x) return x.outcome();
    const auto y = session.axis("1.2");
    if (!y) return y.outcome();
    const std::jthread first([&x](const std::stop_token& stop) {
      move_to_and_fro(*x, 8192, stop);
    });
    const std::jthread second([&y](const std::stop_token& stop) {
      move_to_and_fro(*y, 12288, stop);
    });
    for (bool is_told = false; !session.is_interrupted();) {
      const std::string url = is_told ? "" : url_in(page.output());
      if (!url.empty()) tell(url);
      is_told = is_told || !url.empty();
      if (page.wait(kPoll)) return Outcome::failed(first_line(page.errors()));
      if (bench.has_ended()) return Outcome::failed("the service has ended");
    }
    return Outcome::failed("interrupted");
  }
};

}  // namespace

extern const CommandRow kDemo = row_of<DemoCommand>(
    {.name = "demo",
     .group = CommandGroup::machine,
     .summary = "Start a bench of four axes, two of which move, and the page that shows them",
     .example = "demo --listen 0.0.0.0:8765",
     .deepest = Place::command_line});

}  // namespace vdrive::tool
