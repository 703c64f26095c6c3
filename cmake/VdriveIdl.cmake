# SPDX-License-Identifier: Apache-2.0

if(VDRIVE_PYTHON)
  set(Python3_EXECUTABLE ${VDRIVE_PYTHON})
endif()
find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)

# vdrive_generate_idl(<target> <file>.idl)
# Adds an interface library with the C++ that our generator makes from the file: <file>.hpp and
# <file>_description.hpp.
function(vdrive_generate_idl target idl)
  cmake_path(GET idl STEM name)
  cmake_path(ABSOLUTE_PATH idl)
  set(generator ${PROJECT_SOURCE_DIR}/idl/generator/generate.py)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/generated)
  set(generated ${output}/${name}.hpp ${output}/${name}_description.hpp)
  add_custom_command(
    OUTPUT ${generated}
    COMMAND Python3::Interpreter ${generator} ${idl} ${output}
    DEPENDS ${idl} ${generator}
    COMMENT "Generating C++ from ${name}.idl"
    VERBATIM)
  add_custom_target(${target}_generated DEPENDS ${generated})
  add_library(${target} INTERFACE)
  add_dependencies(${target} ${target}_generated)
  target_include_directories(${target} SYSTEM INTERFACE $<BUILD_INTERFACE:${output}>)
endfunction()
