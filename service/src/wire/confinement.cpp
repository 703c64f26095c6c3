// SPDX-License-Identifier: Apache-2.0
#include "wire/confinement.hpp"

#include "base/log.hpp"

#include <sched.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <initializer_list>
#include <memory>
#include <system_error>

namespace vdrive::service {
namespace {

using Filter = std::unique_ptr<void, decltype(&seccomp_release)>;

/// System calls that neither engine nor wire needs.
constexpr std::initializer_list<int> kForbiddenCalls{SCMP_SYS(execve),
                                                     SCMP_SYS(execveat),
                                                     SCMP_SYS(ptrace),
                                                     SCMP_SYS(process_vm_readv),
                                                     SCMP_SYS(process_vm_writev),
                                                     SCMP_SYS(io_uring_setup),
                                                     SCMP_SYS(bpf),
                                                     SCMP_SYS(mount),
                                                     SCMP_SYS(setns),
                                                     SCMP_SYS(kill),
                                                     SCMP_SYS(tkill),
                                                     SCMP_SYS(rt_sigqueueinfo),
                                                     SCMP_SYS(pidfd_send_signal),
                                                     SCMP_SYS(rt_tgsigqueueinfo),
                                                     SCMP_SYS(unshare),
                                                     SCMP_SYS(pivot_root),
                                                     SCMP_SYS(keyctl)};

constexpr std::initializer_list<int> kFiles{SCMP_SYS(open),
                                            SCMP_SYS(openat),
                                            SCMP_SYS(openat2),
                                            SCMP_SYS(creat),
                                            SCMP_SYS(unlink),
                                            SCMP_SYS(unlinkat),
                                            SCMP_SYS(rename),
                                            SCMP_SYS(renameat),
                                            SCMP_SYS(renameat2),
                                            SCMP_SYS(link),
                                            SCMP_SYS(linkat),
                                            SCMP_SYS(symlink),
                                            SCMP_SYS(symlinkat),
                                            SCMP_SYS(mkdir),
                                            SCMP_SYS(mkdirat),
                                            SCMP_SYS(rmdir),
                                            SCMP_SYS(truncate),
                                            SCMP_SYS(chmod),
                                            SCMP_SYS(fchmodat),
                                            SCMP_SYS(chown),
                                            SCMP_SYS(fchownat),
                                            SCMP_SYS(memfd_create),
                                            SCMP_SYS(mknod),
                                            SCMP_SYS(mknodat),
                                            SCMP_SYS(ftruncate),
                                            SCMP_SYS(fchmod),
                                            SCMP_SYS(fchown),
                                            SCMP_SYS(setxattr),
                                            SCMP_SYS(lsetxattr),
                                            SCMP_SYS(fsetxattr),
                                            SCMP_SYS(utimensat),
                                            SCMP_SYS(name_to_handle_at),
                                            SCMP_SYS(open_by_handle_at)};

/// Refuses a call unless its first argument is `allowed`.
int refuse_unless_first_is(const Filter& filter, int call, scmp_datum_t allowed) {
  const scmp_arg_cmp other{.arg = 0, .op = SCMP_CMP_NE, .datum_a = allowed, .datum_b = 0};
  return seccomp_rule_add_array(filter.get(), SCMP_ACT_ERRNO(EPERM), call, 1, &other);
}

int refuse(const Filter& filter, std::initializer_list<int> calls) {
  int result = 0;
  for (const int call : calls) {
    const int code = seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(EPERM), call, 0);
    result = code < 0 ? code : result;
  }
  return result;
}

/// @return 0, or the library's negative error number.
int load(const Filter& filter) {
  // For all threads, including those of the DDS library.
  const int code = seccomp_attr_set(filter.get(), SCMP_FLTATR_CTL_TSYNC, 1);
  return code < 0 ? code : seccomp_load(filter.get());
}

void log_failure(const char* half, int code) {
  log_warning("confinement={} text=\"cannot install the filter of system calls: {}\"", half,
              std::generic_category().message(-code));
}

}  // namespace

void confine_engine(Network network) {
  prctl(PR_SET_NO_NEW_PRIVS, 1UL, 0UL, 0UL, 0UL);  // NOLINT(*-vararg)
  // Without the privilege, only the filter confines the engine.
  const bool has_own_network = network == Network::leave && unshare(CLONE_NEWNET) == 0;
  const Filter filter(seccomp_init(SCMP_ACT_ALLOW), &seccomp_release);
  int code = refuse(filter, kForbiddenCalls);
  if (code == 0) code = refuse_unless_first_is(filter, SCMP_SYS(socket), AF_UNIX);
  code = code < 0 ? code : load(filter);
  if (code < 0) {
    log_failure("engine", code);
    return;
  }
  log_debug("confinement=engine sockets=unix network={}", has_own_network ? "none" : "host");
}

void confine_wire() {
  prctl(PR_SET_NO_NEW_PRIVS, 1UL, 0UL, 0UL, 0UL);  // NOLINT(*-vararg)
  const Filter filter(seccomp_init(SCMP_ACT_ALLOW), &seccomp_release);
  int code = refuse(filter, kForbiddenCalls);
  code = code < 0 ? code : refuse(filter, kFiles);
  if (code == 0) {  // a failed assertion has to signal its own process
    code = refuse_unless_first_is(filter, SCMP_SYS(tgkill), static_cast<scmp_datum_t>(getpid()));
  }
  code = code < 0 ? code : load(filter);
  if (code < 0) {
    log_failure("wire", code);
    return;
  }
  log_debug("confinement=wire files=none");
}

}  // namespace vdrive::service
