// SPDX-License-Identifier: Apache-2.0
// Creates a session, searches, reads and closes it, again and again, until standard input is
// closed:
//
//   stress_searcher DOMAIN BENCH...
//
// The benches given are always present, and the axis of each is named only-of-BENCH. Prints a line
// "searches N" now and then and at the end, "missed TEXT" for a search that has not found one of
// the benches, and "failed TEXT" for a read that did not succeed.
#include "vdrive/client/session.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::test {
namespace {

void print(std::string_view key, const std::string& value) {
  std::cout << key << ' ' << value << std::endl;  // NOLINT(*-avoid-endl): it may be killed
}

bool is_input_closed() {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  return poll(&input, 1, 0) > 0;
}

/// Searches for all benches and reads by address, or finds the axis by name, in turn.
void search_and_read(const client::SessionOptions& options, const std::vector<std::uint32_t>& there,
                     std::uint64_t number) {
  client::Session session(options);
  const std::uint32_t bench = there[number % there.size()];
  if (number % 2 == 0) {
    const auto found = session.find_benches();
    for (const std::uint32_t one : there) {
      if (std::ranges::find(found, one, &client::BenchInfo::number) == found.end()) {
        print("missed", "bench " + std::to_string(one) + ": " + session.no_bench_found().message());
      }
    }
  }
  const std::string address = std::to_string(bench) + ".1";
  const auto axis =
      number % 2 == 0 ? session.axis(address) : session.axis("only-of-" + std::to_string(bench));
  if (!axis) {
    print("missed", axis.outcome().message());
    return;
  }
  const auto read = axis->read(ObjectAddress{0x6041, 0});
  if (!read) print("failed", read.outcome().message());
}

void run(const std::vector<std::string>& words) {
  client::SessionOptions options;
  options.domain = static_cast<std::uint32_t>(std::stoul(words.at(0)));
  std::vector<std::uint32_t> there;
  for (const std::string& word : std::span(words).subspan(1)) {
    there.push_back(static_cast<std::uint32_t>(std::stoul(word)));
  }
  std::uint64_t searches = 0;
  auto reported = std::chrono::steady_clock::now();
  while (!is_input_closed()) {
    search_and_read(options, there, searches);
    ++searches;
    if (const auto now = std::chrono::steady_clock::now();
        now - reported > std::chrono::seconds{1}) {
      reported = now;
      print("searches", std::to_string(searches));
    }
  }
  print("searches", std::to_string(searches));
}

}  // namespace
}  // namespace vdrive::test

int main(int argc, char** argv) {
  const std::span all(argv, static_cast<std::size_t>(argc));
  vdrive::test::run({all.begin() + 1, all.end()});
}
