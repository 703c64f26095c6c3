# SPDX-License-Identifier: Apache-2.0
# The CMake package: find_package(vdrive REQUIRED COMPONENTS ...), then link the target of that
# name.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/vdrive)

# One export set per part that some components need and others do not. The static libraries for users
# link internal ones, so the package contains the archives of these too, but not their headers: no
# public header refers to them.
install(
  TARGETS vdrive_core
  EXPORT vdrive-core
  ARCHIVE COMPONENT development
  FILE_SET HEADERS COMPONENT development)
install(
  TARGETS vdrive_sessions
  EXPORT vdrive-sessions
  ARCHIVE COMPONENT development
  FILE_SET HEADERS COMPONENT development)
install(TARGETS vdrive_codec vdrive_wire EXPORT vdrive-sessions ARCHIVE COMPONENT development)
install(
  TARGETS vdrive_bench
  EXPORT vdrive-bench
  ARCHIVE COMPONENT development
  FILE_SET HEADERS COMPONENT development)
install(TARGETS vdrive_engine vdrive_settings vdrive_wire_program EXPORT vdrive-bench
        ARCHIVE COMPONENT development)
install(TARGETS vdrive_client vdrive_dds EXPORT vdrive-client ARCHIVE COMPONENT development)
foreach(set core sessions bench client)
  install(EXPORT vdrive-${set} NAMESPACE vdrive:: DESTINATION ${package_dir} COMPONENT development)
endforeach()
install(TARGETS vdrived COMPONENT service)
install(TARGETS vdrive COMPONENT tool)
install(TARGETS vdrive-gateway COMPONENT gateway)
install(TARGETS vdrive-ros2 COMPONENT ros2)
install(TARGETS vdrive-canopen COMPONENT canopen)

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/vdriveConfig.cmake.in ${PROJECT_BINARY_DIR}/vdriveConfig.cmake
  INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/vdriveConfigVersion.cmake
  VERSION ${PROJECT_VERSION}
  COMPATIBILITY SameMajorVersion)
install(FILES ${PROJECT_BINARY_DIR}/vdriveConfig.cmake ${PROJECT_BINARY_DIR}/vdriveConfigVersion.cmake
        DESTINATION ${package_dir} COMPONENT development)

# The unit for further benches: the first unit with another configuration and directory.
set(unit_dir ${PROJECT_SOURCE_DIR}/deploy/systemd)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${unit_dir}/vdrived.service)
file(READ ${unit_dir}/vdrived.service unit)
string(REPLACE "Description=Bench" "Description=%i: bench" unit "${unit}")
string(REPLACE "/etc/vdrive/vdrived.yaml\n" "/etc/vdrive/%i.yaml\n" unit "${unit}")
string(REPLACE "StateDirectory=vdrive\n" "StateDirectory=vdrive-%i\n" unit "${unit}")
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/vdrived@.service CONTENT "${unit}" @ONLY)
install(FILES ${unit_dir}/vdrived.service ${PROJECT_BINARY_DIR}/vdrived@.service
        DESTINATION lib/systemd/system COMPONENT service)
install(FILES ${unit_dir}/vdrive-gateway.service DESTINATION lib/systemd/system COMPONENT gateway)
install(FILES ${unit_dir}/vdrive-ros2.service DESTINATION lib/systemd/system COMPONENT ros2)
install(FILES ${unit_dir}/vdrive-canopen.service DESTINATION lib/systemd/system COMPONENT canopen)
install(FILES ${unit_dir}/realtime.conf DESTINATION ${CMAKE_INSTALL_DATADIR}/vdrive
        COMPONENT service)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/deploy/axes DESTINATION ${CMAKE_INSTALL_DATADIR}/vdrive
        COMPONENT service)
install(FILES ${unit_dir}/vdrived.yaml DESTINATION ${CMAKE_INSTALL_SYSCONFDIR}/vdrive
        COMPONENT service)

# Keep the layout of the project for documents, IDL and examples, so that the links between them
# work.
set(tree ${CMAKE_INSTALL_DATADIR}/doc/vdrive-doc)
install(FILES ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${tree} COMPONENT documents)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${tree} COMPONENT documents)
install(FILES ${PROJECT_SOURCE_DIR}/idl/vdrive_messages.idl ${PROJECT_SOURCE_DIR}/idl/ros_messages.idl
        DESTINATION ${tree}/idl COMPONENT documents)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/clients/examples DESTINATION ${tree}/clients
        COMPONENT documents PATTERN CMakeLists.txt EXCLUDE PATTERN installed EXCLUDE
        PATTERN 08_text_bridge EXCLUDE) # it needs the kit
install(DIRECTORY ${PROJECT_SOURCE_DIR}/clients/python/examples DESTINATION ${tree}/clients/python
        COMPONENT documents)
install(FILES ${PROJECT_SOURCE_DIR}/clients/examples/installed/CMakeLists.txt
        DESTINATION ${tree}/clients/examples COMPONENT documents)
install(FILES ${PROJECT_SOURCE_DIR}/clients/examples/06_raw_dds/CMakeLists.txt
        DESTINATION ${tree}/clients/examples/06_raw_dds COMPONENT documents)

set(packages vdrived:service vdrive:tool vdrive-gateway:gateway vdrive-ros2:ros2
             vdrive-canopen:canopen libvdrive-dev:development vdrive-doc:documents)
if(TARGET vdrive_python)
  list(APPEND packages python3-vdrive:python)
endif()
foreach(package ${packages})
  string(REPLACE ":" ";" package ${package})
  list(GET package 0 name)
  list(GET package 1 component)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name}
          RENAME copyright COMPONENT ${component})
endforeach()
