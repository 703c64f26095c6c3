// SPDX-License-Identifier: Apache-2.0
#include "bridge_program.hpp"
#include "gateway_port.hpp"
#include "hub.hpp"
#include "network_options.hpp"
#include "page.hpp"
#include "standard_streams.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/program_version.hpp"
#include "web_server.hpp"

#include <CLI/CLI.hpp>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace vdrive::gateway {
namespace {

// [1/s] Above the highest rate, messages would be sent faster than ticks of the default period.
constexpr double kLowestRate = 1.0;
constexpr double kHighestRate = 1000.0;
// [characters] 64 bits in hexadecimal, too many to guess over a network.
constexpr std::size_t kShortestToken = 16;

class BadArguments : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Arguments {
  WebSettings web{};
  HubSettings hub{};
  std::string listen = "127.0.0.1:" + std::to_string(bridge::kGatewayPort);
  std::string metrics;  ///< empty = not served
  std::string token;    ///< file; empty = none
};

void declare(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", wire::program_version("vdrive-gateway"));
  bridge::add_domain_option(app, arguments.hub.session.domain);
  bridge::add_network_options(app, arguments.hub.session);
  app.add_option("--listen", arguments.listen,
                 "Address and port for browsers and tools; port 0 = any")
      ->capture_default_str()
      ->type_name("ADDRESS:PORT");
  app.add_option("--metrics", arguments.metrics,
                 "Serve Prometheus metrics at http://ADDRESS:PORT/metrics; port 0 = any")
      ->type_name("ADDRESS:PORT");
  app.add_flag("--control", arguments.hub.is_control,
               "Let clients command axes; without it they only receive");
  app.add_option("--token", arguments.token,
                 "File with the token in its first line; clients send it as ?token=...; required "
                 "unless on loopback")
      ->type_name("FILE");
  app.add_option("--host", arguments.web.rules.hosts,
                 "Host name under which browsers reach this gateway, in addition to localhost and "
                 "addresses")
      ->type_name("NAME");
  app.add_option("--origin", arguments.web.rules.origins,
                 "Origin of another page that may connect, such as https://app.example.org")
      ->type_name("ORIGIN");
  app.add_option("--rate", arguments.hub.rate, "Messages per channel and second, 1 to 1000")
      ->check(CLI::Range(kLowestRate, kHighestRate))
      ->capture_default_str()
      ->type_name("HZ");
  app.add_option("--clients", arguments.web.most_clients, "Connections at the same time, 1 to 1000")
      ->transform(bridge::whole_number(1, 1000))
      ->capture_default_str()
      ->type_name("N");
}

bool is_loopback(const std::string& address) {
  return address.starts_with("127.") || address == "::1";
}

ListenAddress read_address(std::string_view option, const std::string& text) {
  const auto colon = text.rfind(':');  // the last one: an IPv6 address contains others
  const auto port = colon == std::string::npos
                        ? std::nullopt
                        : parse_digits<std::uint16_t>(text.substr(colon + 1));
  if (!port) {
    throw BadArguments(std::string(option) + " " + in_quotes(text) +
                       ": must be an address and a port, such as 127.0.0.1:" +
                       std::to_string(bridge::kGatewayPort));
  }
  ListenAddress listen{.address = text.substr(0, colon), .port = *port};
  if (listen.address.starts_with('[') && listen.address.ends_with(']')) {
    listen.address = listen.address.substr(1, listen.address.size() - 2);
  }
  return listen;
}

std::string read_token(const std::string& file) {
  std::ifstream stream(file);
  std::string token;
  if (!stream || !std::getline(stream, token)) {
    throw BadArguments("--token: cannot read " + in_quotes(file));
  }
  // Editors on Windows end lines with CR LF.
  while (!token.empty() && (token.back() == '\r' || token.back() == ' ')) token.pop_back();
  if (token.size() < kShortestToken ||
      // Only characters that need no escaping in a URL: clients send it as ?token=...
      token.find_first_not_of(
          "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.~") !=
          std::string::npos) {
    throw BadArguments("--token: the first line of " + in_quotes(file) +
                       " must have at least 16 letters, digits, '-', '_', '.' or '~'");
  }
  return token;
}

/// Parses the options that are given as text.
void read_texts(Arguments& arguments) {
  WebSettings& web = arguments.web;
  web.listen = read_address("--listen", arguments.listen);
  if (!arguments.metrics.empty()) web.metrics = read_address("--metrics", arguments.metrics);
  if (!arguments.token.empty()) web.rules.token = read_token(arguments.token);
  if (!is_loopback(web.listen.address) && web.rules.token.empty()) {
    throw BadArguments("--listen " + in_quotes(arguments.listen) +
                       ": other machines can reach this address: give --token");
  }
  arguments.hub.is_token = !web.rules.token.empty();
  client::SessionOptions& session = arguments.hub.session;
  session.find_timeout = bridge::find_timeout_of(session);
}

std::string url_of(const std::string& address, std::uint16_t port) {
  const bool is_v6 = address.find(':') != std::string::npos;
  return "http://" + (is_v6 ? "[" + address + "]" : address) + ":" + std::to_string(port) + "/";
}

int serve(Arguments& arguments) {
  // A client may be gone when its answer is written. Only that write must fail, not the process.
  std::signal(SIGPIPE, SIG_IGN);  // NOLINT(cert-err33-c): it cannot fail for this signal
  read_texts(arguments);
  const WebSettings& settings = arguments.web;
  WebServer server(settings, embedded_page());
  Hub hub(server, arguments.hub);
  std::cout << "vdrive-gateway: " << url_of(settings.listen.address, server.port())
            << (arguments.hub.is_control ? " (clients may command)" : " (view only)") << std::endl;
  if (const auto port = server.metrics_port()) {
    std::cout << "vdrive-gateway: " << url_of(settings.metrics->address, *port) << "metrics"
              << std::endl;
  }
  server.run(hub);
  return bridge::kDone;
}

/// Reads the command line, and serves until SIGINT or SIGTERM.
/// @return the exit code: 0 done, 1 no network or no port, 2 bad command line
int run_command_line(int argument_count, const char* const* argument_list) {
  CLI::App app(
      "Shows benches of virtual servo drives in a browser, Foxglove, Lichtblick and PlotJuggler "
      "over the Foxglove WebSocket protocol.",
      "vdrive-gateway");
  Arguments arguments;
  declare(app, arguments);
  return bridge::run_program<BadArguments>(app, argument_count, argument_list, [&arguments] {
    return serve(arguments);
  });
}

}  // namespace
}  // namespace vdrive::gateway

int main(int argument_count, char** arguments) {
  vdrive::bridge::open_standard_streams();
  // Everything has been released. A static destructor of the DDS library would sleep 100 ms.
  std::quick_exit(vdrive::gateway::run_command_line(argument_count, arguments));
}
