# SPDX-License-Identifier: Apache-2.0
# Builds the web page of the gateway with npm and Vite, in WORK.
#
#   cmake -D SOURCE=DIRECTORY -D TABLES=FILE -D WORK=DIRECTORY -D STAMP=FILE -D NODE=PROGRAM
#         -D NPM=PROGRAM -P build_page.cmake
#
# TABLES becomes src/data/tables.ts. Creates WORK/dist and STAMP. Without node and npm, dist is
# empty. If the packages cannot be fetched, dist is empty and STAMP is not created, so that the next
# build tries again. A page that Vite refuses is an error.

set(oldest_node 18)
set(dist ${WORK}/dist)

function(give_up reason)
  file(REMOVE_RECURSE ${dist})
  file(MAKE_DIRECTORY ${dist})
  message(NOTICE "page of the gateway: ${reason}; the gateway will serve a page that explains how to get it")
endfunction()

# Copies the sources, and removes files that are no longer in the tree.
file(REMOVE_RECURSE ${WORK}/src ${WORK}/public ${WORK}/test)
file(COPY ${SOURCE}/ DESTINATION ${WORK} PATTERN node_modules EXCLUDE PATTERN dist EXCLUDE)
file(COPY_FILE ${TABLES} ${WORK}/src/data/tables.ts)

if(NOT NODE OR NOT NPM)
  give_up("node and npm are missing (deploy/setup.sh --page installs them)")
  file(TOUCH ${STAMP})
  return()
endif()
execute_process(COMMAND ${NODE} -p process.versions.node OUTPUT_VARIABLE version
                OUTPUT_STRIP_TRAILING_WHITESPACE)
if(version VERSION_LESS oldest_node)
  give_up("node ${version} is older than ${oldest_node}")
  file(TOUCH ${STAMP})
  return()
endif()

file(SHA256 ${WORK}/package-lock.json lock)
set(installed "")
if(EXISTS ${WORK}/node_modules/lock.sha256)
  file(READ ${WORK}/node_modules/lock.sha256 installed)
endif()
if(NOT installed STREQUAL lock)
  execute_process(
    COMMAND ${NPM} ci --no-audit --no-fund --prefer-offline --fetch-retries=0 --fetch-timeout=30000
    WORKING_DIRECTORY ${WORK}
    TIMEOUT 180
    RESULT_VARIABLE result
    OUTPUT_QUIET
    ERROR_VARIABLE errors)
  if(NOT result EQUAL 0)
    file(WRITE ${WORK}/npm.log "${errors}")
    give_up("npm ci failed (${WORK}/npm.log), is the registry reachable?")
    return()
  endif()
  file(WRITE ${WORK}/node_modules/lock.sha256 ${lock})
endif()

execute_process(
  COMMAND ${NODE} node_modules/vite/bin/vite.js build --logLevel warn
  WORKING_DIRECTORY ${WORK}
  RESULT_VARIABLE result
  OUTPUT_VARIABLE text
  ERROR_VARIABLE text)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "page of the gateway: vite build failed\n${text}")
endif()
file(TOUCH ${STAMP})
