# SPDX-License-Identifier: Apache-2.0
# The web page of the gateway, built by npm in the build tree.
#
# page_tables is the file with its tables. VDRIVE_GATEWAY_PAGE_DIR is the directory of the built
# files, VDRIVE_GATEWAY_PAGE_STAMP the file to depend on. Without node and npm, or if the registry
# cannot be reached, the directory is empty.

set(vdrive_page_work ${CMAKE_CURRENT_BINARY_DIR}/page)
set(VDRIVE_GATEWAY_PAGE_DIR ${vdrive_page_work}/dist)
set(VDRIVE_GATEWAY_PAGE_STAMP ${vdrive_page_work}/page.stamp)

find_program(VDRIVE_NODE NAMES node nodejs)
find_program(VDRIVE_NPM NAMES npm)

# The imports in TypeScript already list the files, so there is no list here.
file(
  GLOB_RECURSE vdrive_page_sources CONFIGURE_DEPENDS
  ${CMAKE_CURRENT_LIST_DIR}/src/*
  ${CMAKE_CURRENT_LIST_DIR}/public/*
  ${CMAKE_CURRENT_LIST_DIR}/test/*
  ${CMAKE_CURRENT_LIST_DIR}/*.json
  ${CMAKE_CURRENT_LIST_DIR}/*.ts
  ${CMAKE_CURRENT_LIST_DIR}/*.html
  ${CMAKE_CURRENT_LIST_DIR}/.npmrc)
list(FILTER vdrive_page_sources EXCLUDE REGEX "/page/(node_modules|dist)/")

add_custom_command(
  OUTPUT ${VDRIVE_GATEWAY_PAGE_STAMP}
  COMMAND
    ${CMAKE_COMMAND} -D SOURCE=${CMAKE_CURRENT_LIST_DIR} -D TABLES=${page_tables} -D
    WORK=${vdrive_page_work} -D STAMP=${VDRIVE_GATEWAY_PAGE_STAMP} -D NODE=${VDRIVE_NODE} -D
    NPM=${VDRIVE_NPM} -P ${PROJECT_SOURCE_DIR}/cmake/build_page.cmake
  DEPENDS ${vdrive_page_sources} ${page_tables} ${PROJECT_SOURCE_DIR}/cmake/build_page.cmake
  COMMENT "Building the web page of the gateway"
  VERBATIM)
add_custom_target(vdrive_gateway_page DEPENDS ${VDRIVE_GATEWAY_PAGE_STAMP})
