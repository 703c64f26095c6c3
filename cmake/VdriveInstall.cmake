# SPDX-License-Identifier: Apache-2.0
# The CMake package: find_package(vdrive REQUIRED), then link vdrive::client or vdrive::core.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/vdrive)

install(TARGETS vdrive_core vdrive_client EXPORT vdrive-targets FILE_SET HEADERS)
# A static client links the wire, so its archive is in the package. Its headers are not: no public
# header of the others names a DDS type.
install(TARGETS vdrive_wire EXPORT vdrive-targets)
install(TARGETS vdrived vdrive)
install(EXPORT vdrive-targets NAMESPACE vdrive:: DESTINATION ${package_dir})

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/vdriveConfig.cmake.in ${PROJECT_BINARY_DIR}/vdriveConfig.cmake
  INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/vdriveConfigVersion.cmake
  VERSION ${PROJECT_VERSION}
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/vdriveConfig.cmake ${PROJECT_BINARY_DIR}/vdriveConfigVersion.cmake
        DESTINATION ${package_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
