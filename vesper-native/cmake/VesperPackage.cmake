# SPDX-License-Identifier: Apache-2.0
# Makes find_package(Vesper) work in the build tree (-DVesper_DIR=<build>) and after installation.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Vesper)
set(law_files ${CMAKE_CURRENT_LIST_DIR}/VesperLaw.cmake ${CMAKE_CURRENT_LIST_DIR}/vesper_law.map)

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/VesperConfig.cmake.in
  ${CMAKE_BINARY_DIR}/VesperConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/VesperConfigVersion.cmake
  COMPATIBILITY SameMajorVersion)
file(COPY ${law_files} DESTINATION ${CMAKE_BINARY_DIR})

export(TARGETS vesper sdk probe law_kit command NAMESPACE Vesper:: FILE ${CMAKE_BINARY_DIR}/VesperTargets.cmake)
# The probe is installed beside the library, where the engine looks for it.
install(TARGETS vesper sdk probe law_kit EXPORT VesperTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  RUNTIME DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS command EXPORT VesperTargets RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS law_python LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${CMAKE_SOURCE_DIR}/include/vesper ${CMAKE_SOURCE_DIR}/kit/include/vesper DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT VesperTargets NAMESPACE Vesper:: DESTINATION ${package_dir})
install(FILES ${CMAKE_BINARY_DIR}/VesperConfig.cmake ${CMAKE_BINARY_DIR}/VesperConfigVersion.cmake
  ${law_files} DESTINATION ${package_dir})
