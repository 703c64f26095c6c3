// SPDX-License-Identifier: Apache-2.0
// A program started by this process, such as a bridge with its own benches.
#include "arguments.hpp"
#include "child_process.hpp"
#include "errors.hpp"
#include "fork.hpp"
#include "interpreter_lock.hpp"
#include "private_bench.hpp"
#include "python.hpp"
#include "thread_owned.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::python {
namespace {

/// A program that ends with this object and with this process. Its output is kept in memory. In a
/// forked process it is not touched: it belongs to the parent.
class OwnProgram {
 public:
  /// @param command, environment as for ChildProcess
  OwnProgram(const std::vector<std::string>& command, const std::vector<std::string>& environment)
      : program_([command, environment] {
          return std::make_unique<process::ChildProcess>(command, environment);
        }) {}

  /// @return what the program has written so far to standard output, and to standard error.
  [[nodiscard]] py::bytes output() const { return {get().output()}; }

  [[nodiscard]] py::bytes errors() const { return {get().errors()}; }

  /// @return its exit code, or -signal; nothing if it is still running after `patience`.
  [[nodiscard]] std::optional<int> wait(std::int64_t patience) const {
    process::ChildProcess& program = get();
    const Unlocked unlocked;
    return program.wait(milliseconds_of(patience));
  }

  /// Sends SIGTERM, and SIGKILL if it has not ended after `patience`. Can be called repeatedly.
  void stop(std::int64_t patience) const {
    process::ChildProcess& program = get();
    const Unlocked unlocked;
    program.stop(milliseconds_of(patience));
  }

 private:
  [[nodiscard]] process::ChildProcess& get() const {
    origin_.require_own("the program");
    return *program_.get();
  }

  const Origin origin_;
  ThreadOwned<process::ChildProcess> program_;
};

}  // namespace

void add_program(py::module_& module) {
  py::class_<OwnProgram, std::shared_ptr<OwnProgram>>(module, "PrivateProgram")
      .def(py::init(
          &made_here<OwnProgram, const std::vector<std::string>&, const std::vector<std::string>&>))
      .def("output", &OwnProgram::output)
      .def("errors", &OwnProgram::errors)
      .def("wait", &OwnProgram::wait)
      .def("stop", &OwnProgram::stop);
  module.def("find_program", &process::find_program);
}

}  // namespace vdrive::python
