// SPDX-License-Identifier: Apache-2.0
//
// The time of a durable save, from the request of the stepping thread to completion, in turn with a
// bare fsync in the same directory; and of a save of 1,000 axes. Prints one JSON line for each
// figure. The argument is the directory (default: the current one); it should be on a disk.
#include "store/parameter_saver.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace vdrive::service;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kRepetitions = 1'000;
constexpr std::size_t kLargeRepetitions = 20;
constexpr std::uint16_t kManyAxes = 1'000;
constexpr std::size_t kBytes = 1'024;  // about the size of the file of one axis

template <typename Function>
double milliseconds_of(Function function) {
  const auto begin = Clock::now();
  function();
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

void sync_some_bytes(const std::filesystem::path& file) {
  const std::array<char, kBytes> bytes{};
  const int opened = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);  // NOLINT(*-vararg)
  if (opened < 0 || ::write(opened, bytes.data(), kBytes) != kBytes || ::fsync(opened) != 0) {
    throw std::runtime_error("no file can be written in " + file.parent_path().string());
  }
  ::close(opened);
}

void save(ParameterSaver& saver, std::uint16_t axes) {
  static std::int64_t value = 0;
  ++value;
  for (std::uint16_t axis = 1; axis <= axes; ++axis) {
    StoreOrder* const order = saver.free_order();
    order->number = axis;
    order->values.fill(value);
    saver.push();
  }
  static_cast<void>(saver.save_waiting());
  while (const StoreOrder* const order = saver.returned()) {
    if (order->error != 0) throw std::runtime_error("a save failed");
    saver.pop();
  }
}

double percentile_99(std::vector<double>& times) {
  std::sort(times.begin(), times.end());
  return times[times.size() * 99 / 100];
}

void print(const std::string& figure, double value) {
  std::cout << R"({"figure":")" << figure << R"(","value":)" << value << "}\n";
}

void run(const std::filesystem::path& directory) {
  ParameterSaver saver(std::make_unique<ParameterStore>(directory, 1), {});
  std::vector<double> saves;
  std::vector<double> syncs;
  for (std::size_t repetition = 0; repetition < kRepetitions; ++repetition) {
    saves.push_back(milliseconds_of([&] {
      save(saver, 1);
    }));
    syncs.push_back(milliseconds_of([&] {
      sync_some_bytes(directory / "bare");
    }));
  }
  print("durable_save_p99_ms", percentile_99(saves));
  print("bare_fsync_p99_ms", percentile_99(syncs));
  std::vector<double> large;
  for (std::size_t repetition = 0; repetition < kLargeRepetitions; ++repetition) {
    large.push_back(milliseconds_of([&] {
      save(saver, kManyAxes);
    }));
  }
  print("durable_save_1000_axes_slowest_ms", *std::max_element(large.begin(), large.end()));
}

}  // namespace

int main(int argument_count, char** arguments) {
  const std::filesystem::path base = argument_count > 1 ? arguments[1] : ".";
  const auto directory = base / ("vdrive-saves-" + std::to_string(getpid()));
  int code = 0;
  try {
    run(directory);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    code = 1;
  }
  std::filesystem::remove_all(directory);
  return code;
}
