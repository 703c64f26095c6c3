// SPDX-License-Identifier: Apache-2.0
// One-tick steps of a lock-step bench by the client library: what python_figures.py compares with.
//
//   vdrive_step_benchmark DOMAIN STEPS     prints the median and the 99th percentile [us]: of bare
//                                          steps, and of as many steps in turn that show all axes
#include <vdrive/client.hpp>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace vdrive::client;
using Clock = std::chrono::steady_clock;

template <typename Call>
double time_of(const Call& call) {
  const auto begin = Clock::now();
  call();
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

void print(std::vector<double> times) {
  std::ranges::sort(times);
  std::cout << times.at(times.size() / 2) << ' ' << times.at(times.size() * 99 / 100) << '\n';
}

int measure(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: vdrive_step_benchmark DOMAIN STEPS\n";
    return 2;
  }
  SessionOptions options;
  options.domain = static_cast<std::uint32_t>(std::stoul(argv[1]));
  options.find_timeout = std::chrono::seconds(30);
  Session session(options);
  const std::uint32_t bench = session.find_bench().value().number;
  const std::size_t steps = std::stoul(argv[2]);
  std::vector<AxisId> ids;
  for (const Axis& axis : session.axes(bench).value()) ids.push_back(axis.id());
  Follower follower = session.follow(ids, Pace::drive).value();
  Observation sample;
  std::vector<double> bare;
  std::vector<double> shown;
  for (std::size_t i = 0; i < steps; ++i) {
    bare.push_back(time_of([&] {
      static_cast<void>(session.step(bench, 1).value());
    }));
    shown.push_back(time_of([&] {
      if (Outcome seen = follower.next(std::chrono::seconds(10), sample); !seen) {
        throw std::runtime_error(seen.message());
      }
    }));
  }
  print(std::move(bare));
  print(std::move(shown));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return measure(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
