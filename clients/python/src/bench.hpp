// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fork.hpp"
#include "private_bench.hpp"
#include "python.hpp"
#include "thread_owned.hpp"
#include "vdrive/bench/bench.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// The benches of a program: vdrive.Bench holds one of them.
namespace vdrive::python {

/// A bench that ends with this object. In a forked process it is not touched: it belongs to the
/// parent.
class LocalBench {
 public:
  /// @throws bench::BenchError
  explicit LocalBench(const bench::BenchOptions& options) : bench_(options) {}

  /// @return the bus on which sessions reach it.
  /// @throws py::error_already_set if it has ended, and in a forked process
  [[nodiscard]] std::shared_ptr<wire::LocalBus> bus() const;

  /// Can be called repeatedly. Does nothing in a forked process.
  void close();

 private:
  const Origin origin_;
  std::optional<bench::Bench> bench_;
};

/// A service that ends with this object.
class OwnBench {
 public:
  OwnBench(const std::string& service, const std::vector<std::string>& arguments,
           std::optional<std::uint32_t> domain)
      : bench_([service, arguments, domain] {
          return std::make_unique<process::PrivateBench>(service, arguments, domain);
        }) {
    wait_until_ready();
  }

  /// @throws py::error_already_set if it has ended, and in a forked process
  [[nodiscard]] std::uint32_t domain() const;

  /// Waits until the service has ended. Can be called repeatedly. Does nothing in a forked process:
  /// the bench belongs to the parent.
  void close();

 private:
  void wait_until_ready();

  const Origin origin_;
  ThreadOwned<process::PrivateBench> bench_;
};

}  // namespace vdrive::python
