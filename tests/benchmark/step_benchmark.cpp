// SPDX-License-Identifier: Apache-2.0
// One-tick steps of a lock-step bench through the client library: the reference for
// python_figures.py.
//
//   vdrive_step_benchmark DOMAIN STEPS     prints their median [us]
#include <vdrive/client.hpp>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

namespace {

using namespace vdrive::client;
using Clock = std::chrono::steady_clock;

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
  std::vector<double> times;
  for (std::size_t i = 0; i < steps; ++i) {
    const auto begin = Clock::now();
    static_cast<void>(session.step(bench, 1).value());
    times.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
  }
  std::ranges::sort(times);
  std::cout << times.at(times.size() / 2) << '\n';
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
