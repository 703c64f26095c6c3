// SPDX-License-Identifier: Apache-2.0
// DDS participants for a module that must not load the DDS library before it is needed: they come
// from a shared object next to the module.
#include "loader/dds_entry.hpp"
#include "network_participant.hpp"
#include "vdrive/text.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <string>

extern "C" void vdrive_dds_loader() noexcept;

namespace vdrive::wire {
namespace {

constexpr const char* kFile = "libvdrive_dds.so";

/// @return the shared object or program that contains this code.
std::filesystem::path own_file() {
  Dl_info info{};
  // NOLINTNEXTLINE(*-reinterpret-cast): the function takes an address of any kind
  if (dladdr(reinterpret_cast<const void*>(&vdrive_dds_loader), &info) == 0) return {};
  return info.dli_fname;
}

[[noreturn]] void refuse(const std::string& reason) {
  throw NetworkError("the DDS library cannot be loaded: " + reason + ". Sessions over DDS need " +
                     kFile + " next to " + own_file().filename().string() +
                     " and the Fast DDS library (Debian 12: libfastrtps2.9, 13: libfastdds3.1); a "
                     "bench in this process needs neither");
}

/// Both files must be from the same build, because objects of a participant and exceptions pass
/// between them.
/// @throws NetworkError when they are not
void require_same_build(void* library, const std::filesystem::path& file) {
  const void* const found = dlsym(library, kDdsBuild);
  const std::string build =
      found == nullptr ? "an older version" : *static_cast<const char* const*>(found);
  if (build == VDRIVE_DDS_BUILD) return;
  throw NetworkError("the DDS library cannot be used: " + file.string() + " was built as \"" +
                     build + "\", but " + own_file().string() + " as \"" + VDRIVE_DDS_BUILD +
                     "\". Install both from one build; a bench in this process needs no DDS");
}

/// The module and the shared object contain some of the same code, each in its own copy: such code
/// must not keep state for both. Never unloads the shared object, because the DDS library has
/// threads.
ParticipantMaker load() {
  const std::filesystem::path file = own_file().parent_path() / kFile;
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (library == nullptr) refuse(dlerror());  // NOLINT(concurrency-mt-unsafe): of this thread
  require_same_build(library, file);
  void* const entry = dlsym(library, kDdsEntry);
  if (entry == nullptr) refuse(file.string() + " has no " + kDdsEntry);
  // NOLINTNEXTLINE(*-reinterpret-cast): the type of what has this name
  return reinterpret_cast<DdsEntry*>(entry)();
}

std::unique_ptr<Participant> make_loaded_participant(const NetworkSettings& settings,
                                                     const std::string& name) {
  static const ParticipantMaker maker = load();  // load() runs again after an exception
  return maker(settings, name);
}

}  // namespace
}  // namespace vdrive::wire

// Like vdrive_dds_participant in dds/dds_participant.cpp.
extern "C" [[gnu::constructor(vdrive::wire::kBeforeConstructors)]] void
vdrive_dds_loader() noexcept {
  vdrive::wire::provide_network_participant(&vdrive::wire::make_loaded_participant);
}
