# SPDX-License-Identifier: Apache-2.0
# Writes the files of the gateway's web page into a C++ source.
#
#   cmake -D PAGE=DIRECTORY -D OUTPUT=FILE -P embed_page.cmake

set(files "")
if(PAGE AND IS_DIRECTORY "${PAGE}")
  file(GLOB_RECURSE files RELATIVE "${PAGE}" "${PAGE}/*")
  list(SORT files)
endif()

set(arrays "")
set(rows "")
set(count 0)
foreach(file IN LISTS files)
  file(READ "${PAGE}/${file}" bytes HEX)
  string(LENGTH "${bytes}" digits)
  if(digits EQUAL 0)
    continue()
  endif()
  math(EXPR size "${digits} / 2")
  # Octal would be shorter, but CMake reads hex.
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(APPEND arrays "constexpr std::array<unsigned char, ${size}> kFile${count}{${bytes}};\n")
  string(APPEND rows "    PageFile{\"${file}\", view(kFile${count})},\n")
  math(EXPR count "${count} + 1")
endforeach()

if(count EQUAL 0)
  set(text "// Made by cmake/embed_page.cmake: this build has no page.
#include \"page.hpp\"

namespace vdrive::gateway {

Page embedded_page() {
  return {};
}

}  // namespace vdrive::gateway
")
else()
  set(text "// Made by cmake/embed_page.cmake.
#include \"page.hpp\"

#include <array>

namespace vdrive::gateway {
namespace {

template <typename Bytes>
std::string_view view(const Bytes& bytes) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes are seen as characters
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

${arrays}
}  // namespace

Page embedded_page() {
  static const std::array files{
${rows}  };
  return files;
}

}  // namespace vdrive::gateway
")
endif()
file(WRITE "${OUTPUT}" "${text}")
