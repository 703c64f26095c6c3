# SPDX-License-Identifier: Apache-2.0
# Settings common to all targets.

set(vdrive_warnings
    -Wall
    -Wextra
    -Wpedantic
    -Wconversion
    -Wshadow
    -Wold-style-cast
    -Wnon-virtual-dtor
    -Woverloaded-virtual
    -Wdouble-promotion)

# With large pages for its memory, clang takes a tenth to a fifth less time, on kernels that provide
# them on request. gcc takes longer with them.
set(vdrive_clang_environment env GLIBC_TUNABLES=glibc.malloc.hugetlb=1)

# The compiler cache is used if found. CCACHE_SLOPPINESS is needed to cache precompiled headers. Paths
# below the source tree are made relative, so that a second clone of the repository starts with a warm
# cache.
find_program(VDRIVE_CCACHE ccache)
if(PROJECT_IS_TOP_LEVEL AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    set(CMAKE_CXX_COMPILER_LAUNCHER ${vdrive_clang_environment})
  endif()
  if(VDRIVE_CCACHE)
    list(APPEND CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_SLOPPINESS=pch_defines,time_macros
         CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${VDRIVE_CCACHE})
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      set(vdrive_ccache_options -fpch-preprocess)
    endif()
  endif()
endif()

# Tests are about a hundred programs: lld links them in a third of the time of the default linker.
# It also links everything else in a build that is not for users.
if(PROJECT_IS_TOP_LEVEL)
  include(CheckLinkerFlag)
  check_linker_flag(CXX -fuse-ld=lld VDRIVE_HAS_LLD)
  if(VDRIVE_HAS_LLD AND (VDRIVE_SANITIZE OR VDRIVE_OPTIMISE STREQUAL "DRIVE"))
    add_link_options(-fuse-ld=lld)
  endif()
endif()

# The thread sanitizer of this compiler generation maps fixed addresses and does not start if the
# kernel randomises more address bits than it expects. CMake runs test programs, and queries their
# tests, through this prefix.
if(VDRIVE_SANITIZE MATCHES "thread" AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
  find_program(VDRIVE_SETARCH setarch)
  if(VDRIVE_SETARCH)
    execute_process(COMMAND ${VDRIVE_SETARCH} -R true RESULT_VARIABLE failed ERROR_QUIET)
    if(NOT failed)
      set(CMAKE_CROSSCOMPILING_EMULATOR ${VDRIVE_SETARCH} -R)
    endif()
  endif()
endif()

# The hardening options that Debian uses for its own programs, in optimised builds.
# Position-independent executables are the default of the compiler there. The core is built without
# these options: it processes numbers, not bytes from outside, and every tick would pay for them.
set(vdrive_optimised $<CONFIG:RelWithDebInfo,Release>)
set(vdrive_hardening_options -fstack-protector-strong -fstack-clash-protection)
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  list(APPEND vdrive_hardening_options -fcf-protection)
endif()
list(TRANSFORM vdrive_hardening_options REPLACE ".+" "$<${vdrive_optimised}:\\0>")

# vdrive_list_links(<target> <property>)
# Writes what the target links, one name per line, for the architecture test, which has a table of
# what is allowed.
function(vdrive_list_links target property)
  if(NOT CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/tests")
    file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/links/${target}.txt
         CONTENT "$<JOIN:$<TARGET_PROPERTY:${target},${property}>,\n>\n")
  endif()
endfunction()

# vdrive_target_defaults(<target> [GENERATED])
# Language, warnings and sanitizers of one of our targets. All of it is PRIVATE, so whoever links
# us, in the tree or installed, inherits none of it. GENERATED code gets no warnings and no lint.
function(vdrive_target_defaults target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "GENERATED" "" "")
  vdrive_list_links(${target} LINK_LIBRARIES)
  set_target_properties(${target} PROPERTIES CXX_STANDARD_REQUIRED ON CXX_EXTENSIONS OFF)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE ${vdrive_ccache_options})
  # Below 512 MiB, the garbage collector of the compiler need not run again and again.
  target_compile_options(
    ${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-heapsize=524288>)
  target_compile_definitions(${target} PRIVATE $<$<CONFIG:Debug>:_GLIBCXX_ASSERTIONS>
                                               $<${vdrive_optimised}:_FORTIFY_SOURCE=2>
                                               $<${vdrive_asserts}:VDRIVE_ASSERTS>)
  if(NOT target STREQUAL vdrive_core)
    target_compile_options(${target} PRIVATE ${vdrive_hardening_options})
  endif()
  target_link_options(${target} PRIVATE $<${vdrive_optimised}:LINKER:-z,relro,-z,now>)
  if(VDRIVE_OPTIMISE STREQUAL "DRIVE" AND target MATCHES "^vdrive_(codec|engine|messages|sessions|wire)$")
    # Most tests use these: without any optimisation the tests would lose more time than the build
    # saves.
    target_compile_options(${target} PRIVATE -O1)
  elseif(VDRIVE_OPTIMISE STREQUAL "DRIVE" AND NOT target STREQUAL vdrive_core)
    # _FORTIFY_SOURCE requires optimisation.
    target_compile_options(${target} PRIVATE -O0 -U_FORTIFY_SOURCE)
  endif()
  if(arg_GENERATED)
    target_compile_options(${target} PRIVATE -w)
  else()
    target_compile_options(${target} PRIVATE ${vdrive_warnings}
                                             $<$<BOOL:${VDRIVE_WARNINGS_AS_ERRORS}>:-Werror>)
    if(VDRIVE_LINT)
      set_target_properties(${target} PROPERTIES CXX_COMPILER_LAUNCHER ${PROJECT_SOURCE_DIR}/tests/checks/lint.sh)
      set_property(GLOBAL APPEND PROPERTY vdrive_linted $<TARGET_OBJECTS:${target}>)
      # The build system knows the headers of a file, but not that its lint depends on these rules.
      set(lint_rules "")
      foreach(file IN ITEMS .clang-tidy tests/checks/lint.sh)
        set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${file})
        file(SHA256 ${PROJECT_SOURCE_DIR}/${file} sum)
        string(APPEND lint_rules ${sum})
      endforeach()
      target_compile_definitions(${target} PRIVATE VDRIVE_LINT_RULES=0x${lint_rules})
    endif()
  endif()
  if(VDRIVE_SANITIZE)
    set(sanitizers ${VDRIVE_SANITIZE})
    if(sanitizers MATCHES "address" AND CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/tests"
       AND NOT CMAKE_CURRENT_SOURCE_DIR STREQUAL "${PROJECT_SOURCE_DIR}/tests/fuzz")
      # The expressions of a test are not what is tested, and with all checks they would take as
      # long to compile as everything else. Fuzzers are built from the sources of the libraries.
      set(sanitizers address)
    endif()
    target_compile_options(${target} PRIVATE -fsanitize=${sanitizers} -fno-sanitize-recover=all
                                             -fno-omit-frame-pointer)
    target_compile_definitions(${target} PRIVATE VDRIVE_SANITIZED)
    if(VDRIVE_SANITIZE MATCHES "thread")
      target_compile_definitions(${target} PRIVATE VDRIVE_WATCHES_THREADS)
    endif()
    if(target MATCHES "^vdrive_(codec|core|engine|simulation_world|wire)$")
      # Every test uses these: the tests take a third of the time, and the build hardly longer.
      target_compile_options(${target} PRIVATE $<$<CONFIG:Debug>:-O1>)
    endif()
    # BUILD_INTERFACE: a program that links the library in this build needs the runtime too; an
    # installed package must not mention it.
    target_link_options(${target} PUBLIC $<BUILD_INTERFACE:-fsanitize=${VDRIVE_SANITIZE}>)
  endif()
endfunction()

# vdrive_make_position_independent(<target>)
# For code that others link into shared libraries, such as the Python module and users' plug-ins.
# Our functions still call each other directly, as in a program.
function(vdrive_make_position_independent target)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fno-semantic-interposition>)
endfunction()

# vdrive_add_library(<room> HEADERS <file>... SOURCES <file>... [INTERNAL] [BESIDE])
# Adds the static library vdrive_<room>, available in the tree as vdrive::<room>, exactly as after
# find_package. Public headers are below include/, private ones below src/. The target
# all_verify_interface_header_sets compiles each listed public header on its own.
# INTERNAL: the archive is installed because others link it, but its headers are not. CMake installs
# an exported target only together with its header sets. So these headers belong to a separate
# target, which only verifies them.
# BESIDE: no program outside the tree includes its headers, so all of them are below src/, next to
# their sources. Whoever links it includes them the same way as its own sources do.
function(vdrive_add_library room)
  cmake_parse_arguments(PARSE_ARGV 1 arg "INTERNAL;BESIDE" "" "HEADERS;SOURCES")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "vdrive_add_library(${room}): unknown ${arg_UNPARSED_ARGUMENTS}")
  endif()
  set(target vdrive_${room})
  add_library(${target} STATIC ${arg_SOURCES})
  add_library(vdrive::${room} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${room})
  if(NOT arg_BESIDE)
    set_target_properties(${target} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
    vdrive_make_position_independent(${target})
  endif()
  target_include_directories(${target} PRIVATE src)
  vdrive_target_defaults(${target})
  if(arg_INTERNAL)
    target_include_directories(
      ${target} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>)
    add_library(${target}_headers INTERFACE)
    set_target_properties(${target}_headers PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
    target_link_libraries(${target}_headers INTERFACE ${target})
    target_sources(
      ${target}_headers INTERFACE FILE_SET HEADERS BASE_DIRS include FILES ${arg_HEADERS})
  elseif(arg_BESIDE)
    target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/src>)
    target_sources(${target} PRIVATE FILE_SET HEADERS BASE_DIRS src FILES ${arg_HEADERS})
  else()
    target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${arg_HEADERS})
  endif()
endfunction()

# vdrive_precompile(<target> <header>...)
# Precompiles library headers that most sources of the target include, because reading them takes
# longer than the rest of a source file. Not done when clang-tidy reads the sources, each of which
# must stand alone, nor when the sources of the target are compiled together and read the headers
# only once or twice: that takes no longer than compiling the headers, and nothing has to wait for
# it.
function(vdrive_precompile target)
  if(VDRIVE_LINT)
    return()
  endif()
  get_target_property(together ${target} UNITY_BUILD)
  if(together)
    return()
  endif()
  target_precompile_headers(${target} PRIVATE ${ARGN})
endfunction()

# vdrive_compile_together(<target> [APART <file>...] [FOR_LINT])
# With VDRIVE_UNITY_BUILD up to 64 sources of the target are compiled together, so they share the
# parsing of headers and templates, which clang-tidy would otherwise repeat for each of its checks.
# Names in their unnamed namespaces must differ, or a call could silently match the wrong function.
# The architecture test reads the list written here.
# APART: sources whose names cannot differ. FOR_LINT: compile together only for clang-tidy and in a
# build in which nothing is measured (VDRIVE_OPTIMISE, VDRIVE_SANITIZE); otherwise separately.
function(vdrive_compile_together target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "FOR_LINT" "" "APART")
  set_target_properties(${target} PROPERTIES vdrive_apart "${arg_APART}")
  get_target_property(together ${target} SOURCES)
  list(REMOVE_ITEM together ${arg_APART})
  list(FILTER together INCLUDE REGEX "\\.cpp$")
  list(TRANSFORM together PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  list(JOIN together "\n" together)
  file(WRITE ${PROJECT_BINARY_DIR}/compiled_together/${target}.txt "${together}\n")
  if(arg_FOR_LINT AND NOT VDRIVE_LINT AND NOT VDRIVE_SANITIZE AND VDRIVE_OPTIMISE STREQUAL "ALL")
    return()
  endif()
  if(VDRIVE_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 64)
    set_source_files_properties(${arg_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    # A source that is included is not a header: its unnamed namespace belongs to one object.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# vdrive_add_executable(<target> SOURCES <file>...)
# A program for users, in <build>/bin.
function(vdrive_add_executable target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES")
  add_executable(${target} ${arg_SOURCES})
  set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  vdrive_target_defaults(${target})
endfunction()

# vdrive_print_into(<file> <program> [<input file>...])
# Writes what a program of this build prints about its input files. An unchanged file keeps its time
# stamp, so that nothing depending on it is built again.
function(vdrive_print_into file program)
  cmake_path(GET file FILENAME name)
  set(printed ${CMAKE_CURRENT_BINARY_DIR}/${name}.printed)
  add_custom_command(
    OUTPUT ${file}
    COMMAND ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:${program}> ${ARGN} > ${printed}
    COMMAND ${CMAKE_COMMAND} -E copy_if_different ${printed} ${file}
    DEPENDS ${program} ${ARGN}
    COMMENT "Writing ${name}"
    VERBATIM)
endfunction()

# Tests that check wall-clock times have the label timed in addition to their own, and these
# properties: they run before all others, and at most two at a time with the six jobs of the preset
# release. A machine without a free processor cannot meet such times, so .ci/run repeats a test with
# this label that missed a deadline.
set(VDRIVE_TIMED_TEST PROCESSORS 3 COST 900)
# Most tests over DDS wait: start them before suites of unit tests, which keep the processor busy to
# the end.
set(VDRIVE_DDS_TEST COST 10)
# Start these tests early: they have the lowest priority, get almost no time while others keep the
# machine busy, and might end after all the others.
set(VDRIVE_CALCULATING_TEST COST 500 TIMEOUT 1800)
find_program(VDRIVE_CHRT chrt)

# The interpreter of the system, because its headers and numpy are installed as packages. Another one
# might come first in PATH and take ten times as long to start.
find_program(VDRIVE_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)

# vdrive_include_in_ctest(<name> <text>)
# Makes ctest read the text when it starts, because it may refer to files that only a build writes.
function(vdrive_include_in_ctest name text)
  set(file ${CMAKE_CURRENT_BINARY_DIR}/${name}.cmake)
  file(WRITE ${file} "${text}")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${file})
endfunction()

# Passes the cases of a GoogleTest program to ctest. gtest_discover_tests does not know suites and
# gives all tests the same labels.
function(vdrive_discover_tests name labels properties timed full each)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/${name}_tests.cmake)
  get_target_property(emulator ${name} CROSSCOMPILING_EMULATOR)
  if(NOT emulator)
    set(emulator "")
  endif()
  add_custom_command(
    TARGET ${name}
    POST_BUILD
    BYPRODUCTS ${output}
    COMMAND
      ${CMAKE_COMMAND} -D "program=$<TARGET_FILE:${name}>" -D "emulator=${emulator}" -D "name=${name}" -D
      "directory=${CMAKE_CURRENT_BINARY_DIR}" -D "output=${output}" -D "labels=${labels}" -D
      "properties=${properties}" -D "timed=${timed}" -D "timed_properties=${VDRIVE_TIMED_TEST}" -D "full=${full}" -D
      "each=${each}" -P ${PROJECT_SOURCE_DIR}/cmake/discover_tests.cmake
    VERBATIM)
  string(CONFIGURE [[
if(EXISTS "@output@")
  include("@output@")
else()
  add_test(@name@_is_not_built "")
  set_tests_properties(@name@_is_not_built PROPERTIES LABELS "@labels@")
endif()
]] text @ONLY)
  vdrive_include_in_ctest(${name}_cases "${text}")
endfunction()

# vdrive_add_test(<name> LABEL unit|dds|full SOURCES <file>... [LIBRARIES <target>...]
#                 [TIMED <regex>] [FULL <regex>] [EACH] [CALCULATES] [BRIDGE] [ONE_THREAD]
#                 [THREADS <filter>] [SHARDS <number>])
# Adds a GoogleTest program. Each of its tests is a ctest case with its own process; with the label
# unit, each suite is one, because most of these tests take less time than starting a process. Under
# a sanitizer a unit test program is one case.
#   EACH        its tests take long: each is a case, even with the label unit
#   TIMED       its tests whose names match check times; each is a case
#   FULL        its tests whose names match have the label full; each is a case
#   CALCULATES  its tests never wait, and run with the lowest priority
#   BRIDGE      it tests a bridge; its tests have the label bridge as well
#   ONE_THREAD  it starts no thread: a build that searches for data races omits it
#   THREADS     only its tests in this GoogleTest filter start threads: a build that searches for
#               data races runs no others
#   SHARDS      it takes long under a sanitizer: split into this number of cases
# ./tests/run.sh runs the tests with the labels unit and dds, except those of bridges, and builds the
# target chosen_tests for that. Tests with the label full wait or compute for a long time and run only
# with --full (docs/explanation/testing.md). A program is given
#   VDRIVE_SOURCE_DIR   the source tree, for tests/data and the scenarios
#   VDRIVE_SERVICE, VDRIVE_TOOL   (not label unit) the programs vdrived and vdrive of this build; a test without
#                       DDS that calls the tool is given to vdrive_call_tool (tests/CMakeLists.txt)
# With VDRIVE_NIGHTLY=1 in the environment, tests do more of their repeated work, such as random cases
# (tests/support/effort.hpp). The target unit_tests builds the test programs with the label unit; the
# targets dds_tests and full_tests build those with their labels.
function(vdrive_add_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "EACH;CALCULATES;BRIDGE;ONE_THREAD" "LABEL;TIMED;FULL;SHARDS;THREADS" "SOURCES;LIBRARIES")
  if(NOT arg_LABEL MATCHES "^(unit|dds|full)$" OR NOT arg_SOURCES OR arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "vdrive_add_test(${name} LABEL unit|dds|full SOURCES ... [LIBRARIES ...])")
  endif()
  add_executable(${name} ${arg_SOURCES})
  vdrive_target_defaults(${name})
  if(arg_ONE_THREAD AND VDRIVE_SANITIZE MATCHES "thread")
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)
    return()
  endif()
  target_link_libraries(${name} PRIVATE ${arg_LIBRARIES} GTest::gmock GTest::gtest_main)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(${name} PRIVATE VDRIVE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(TARGET vdrive_test_headers)
    target_precompile_headers(${name} REUSE_FROM vdrive_test_headers)
  endif()
  if(NOT TARGET ${arg_LABEL}_tests)
    add_custom_target(${arg_LABEL}_tests)
  endif()
  add_dependencies(${arg_LABEL}_tests ${name})
  set(labels ${arg_LABEL})
  if(arg_BRIDGE)
    list(APPEND labels bridge)
    if(NOT TARGET bridge_tests)
      add_custom_target(bridge_tests)
    endif()
    add_dependencies(bridge_tests ${name})
  elseif(NOT arg_LABEL STREQUAL "full")
    add_dependencies(chosen_tests ${name})
  endif()
  if(NOT arg_LABEL STREQUAL "unit")
    target_compile_definitions(${name} PRIVATE VDRIVE_SERVICE="$<TARGET_FILE:vdrived>"
                                               VDRIVE_TOOL="$<TARGET_FILE:vdrive>")
    add_dependencies(${name} vdrived vdrive)
    target_link_libraries(${name} PRIVATE vdrive_test_support)
  endif()
  if(VDRIVE_SANITIZE AND arg_LABEL STREQUAL "unit")
    # Starting a program under a sanitizer takes long, so many of its tests run in one process.
    if(NOT arg_SHARDS)
      set(arg_SHARDS 1)
    endif()
    set(filter)
    if(arg_THREADS AND VDRIVE_SANITIZE MATCHES "thread")
      set(filter "--gtest_filter=${arg_THREADS}")
    endif()
    foreach(shard RANGE 1 ${arg_SHARDS})
      math(EXPR index "${shard} - 1")
      add_test(NAME ${name}.${shard} COMMAND ${name} --gtest_brief=1 ${filter})
      set_tests_properties(
        ${name}.${shard} PROPERTIES LABELS "${labels}" TIMEOUT 1800
                                    FAIL_REGULAR_EXPRESSION "] 0 tests from"
                                    ENVIRONMENT "GTEST_TOTAL_SHARDS=${arg_SHARDS};GTEST_SHARD_INDEX=${index}")
    endforeach()
    return()
  endif()
  set(order)
  if(NOT arg_LABEL STREQUAL "unit")
    set(order ${VDRIVE_DDS_TEST})
  endif()
  if(arg_CALCULATES)
    set(order ${VDRIVE_CALCULATING_TEST})
    if(VDRIVE_CHRT)
      set_target_properties(${name} PROPERTIES CROSSCOMPILING_EMULATOR "${VDRIVE_CHRT};--idle;0")
    endif()
  endif()
  if(NOT arg_LABEL STREQUAL "unit")
    set(arg_EACH ON)
  endif()
  vdrive_discover_tests(${name} "${labels}" "${order}" "${arg_TIMED}" "${arg_FULL}" ${arg_EACH})
endfunction()

# vdrive_program_of(<document> <file>)
# Writes the first C++ program of a document to a file in the present build directory, and again
# whenever the document changes.
function(vdrive_program_of document file)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${document})
  file(READ ${document} text)
  string(FIND "${text}" "```cpp\n" begin)
  if(begin EQUAL -1)
    message(FATAL_ERROR "${document} has no program in C++")
  endif()
  math(EXPR begin "${begin} + 7")
  string(SUBSTRING "${text}" ${begin} -1 text)
  string(FIND "${text}" "```" end)
  string(SUBSTRING "${text}" 0 ${end} text)
  file(CONFIGURE OUTPUT ${file} CONTENT "${text}" @ONLY)
endfunction()
