# SPDX-License-Identifier: Apache-2.0
# Queries a GoogleTest program for its tests and writes its ctest cases: one per suite, and one per
# test that is its own case. vdrive_add_test calls this after each build of the program.
#
#   cmake -D program=FILE -D emulator=COMMAND -D name=NAME -D directory=WORKING_DIRECTORY -D output=FILE
#         -D labels=LIST -D properties=LIST -D timed=REGEX -D timed_properties=LIST -D full=REGEX
#         -D each=BOOL -P discover_tests.cmake
#
#   timed, full   a test whose name matches is its own case, with the label timed or full
#   each          every test is its own case
#
# If a test that is its own case skips itself, ctest counts it as skipped too.

execute_process(
  COMMAND ${emulator} ${program} --gtest_list_tests
  OUTPUT_VARIABLE listed
  ERROR_VARIABLE errors
  RESULT_VARIABLE failed
  TIMEOUT 60)
if(failed)
  message(FATAL_ERROR "${program} does not list its tests: ${failed}\n${errors}")
endif()

set(text "")
# Passes the case to ctest; it runs the tests selected by the filter.
function(add_case case filter case_labels)
  set(line "add_test([==[${case}]==]")
  foreach(word IN LISTS emulator ITEMS ${program} --gtest_filter=${filter})
    string(APPEND line " [==[${word}]==]")
  endforeach()
  string(APPEND text "${line})\nset_tests_properties([==[${case}]==] PROPERTIES LABELS [==[${case_labels}]==]"
         " WORKING_DIRECTORY [==[${directory}]==]")
  foreach(word IN LISTS ARGN)
    string(APPEND text " [==[${word}]==]")
  endforeach()
  string(APPEND text ")\n")
  set(text "${text}" PARENT_SCOPE)
endfunction()

set(suite "")
set(alone "") # the tests of the suite that stand alone
set(others 0)
macro(end_suite)
  if(others)
    list(JOIN alone ":" left_out)
    if(alone)
      string(PREPEND left_out "-")
    endif()
    add_case(${name}.${suite} "${suite}.*${left_out}" "${labels}" ${properties})
  endif()
  set(alone "")
  set(others 0)
endmacro()

# Removes comments, which contain the values of test parameters and so can be any text.
string(REGEX REPLACE " +#[^\n]*" "" listed "${listed}")
string(REGEX MATCHALL "[^\n]+" lines "${listed}")
foreach(line IN LISTS lines)
  if(line MATCHES "^([A-Za-z0-9_/]+)\\.$")
    end_suite()
    set(suite ${CMAKE_MATCH_1})
  elseif(line MATCHES "^  ([A-Za-z0-9_/]+)$" AND suite)
    set(test ${suite}.${CMAKE_MATCH_1})
    set(test_labels "${labels}")
    set(test_properties "${properties}")
    if(full AND test MATCHES "${full}")
      set(test_labels full)
    endif()
    if(timed AND test MATCHES "${timed}")
      list(APPEND test_labels timed)
      set(test_properties "${timed_properties}")
    endif()
    if(each OR NOT test_labels STREQUAL labels)
      list(APPEND alone ${test})
      add_case(${test} ${test} "${test_labels}" ${test_properties} SKIP_REGULAR_EXPRESSION "\\[  SKIPPED \\]")
    else()
      math(EXPR others "${others} + 1")
    endif()
  elseif(line MATCHES "^  |\\.$")
    message(FATAL_ERROR "${program}: '${line}' is no name of a test or of a suite")
  endif()
endforeach()
end_suite()
if(NOT text)
  message(FATAL_ERROR "${program} lists no test:\n${listed}")
endif()
file(WRITE ${output} "${text}")
