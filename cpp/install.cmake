# What `cmake --install` puts into a prefix. All of it is relocatable, unless a directory is given
# as an absolute one; the Python wheel takes the component `python` alone.
include(CMakePackageConfigHelpers)

set(_asap_cmake_dir "${CMAKE_INSTALL_LIBDIR}/cmake/asap")
set(_asap_pc_dir "${CMAKE_INSTALL_LIBDIR}/pkgconfig")

foreach(_layer ${ASAP_LAYERS})
  install(DIRECTORY include/asap/${_layer} DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/asap"
          COMPONENT development FILES_MATCHING PATTERN "*.hpp")
endforeach()
install(DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}/include/asap" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
        COMPONENT development FILES_MATCHING PATTERN "*.hpp")

set(_libraries core ${ASAP_LIBRARIES})
list(TRANSFORM _libraries PREPEND asap_ OUTPUT_VARIABLE _targets)
install(TARGETS ${_targets} EXPORT asap-targets
        ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development)
install(EXPORT asap-targets NAMESPACE asap:: DESTINATION "${_asap_cmake_dir}" COMPONENT development)

configure_package_config_file(asap-config.cmake.in asap-config.cmake
                              INSTALL_DESTINATION "${_asap_cmake_dir}")
write_basic_package_version_file(asap-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/asap-config.cmake"
              "${CMAKE_CURRENT_BINARY_DIR}/asap-config-version.cmake"
        DESTINATION "${_asap_cmake_dir}" COMPONENT development)

if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}")
  set(_asap_pc_prefix "${CMAKE_INSTALL_PREFIX}")
else()
  file(RELATIVE_PATH _asap_prefix_from_pc "/${_asap_pc_dir}" "/")
  set(_asap_pc_prefix "\${pcfiledir}/${_asap_prefix_from_pc}")
endif()
# What is absolute takes the place of the prefix.
cmake_path(APPEND _asap_pc_libdir "\${prefix}" "${CMAKE_INSTALL_LIBDIR}")
cmake_path(APPEND _asap_pc_includedir "\${prefix}" "${CMAKE_INSTALL_INCLUDEDIR}")
set(_asap_requires "")
set(_asap_threads "-pthread")
foreach(_library ${_libraries})
  configure_file(asap.pc.in asap-${_library}.pc @ONLY)
  install(FILES "${CMAKE_CURRENT_BINARY_DIR}/asap-${_library}.pc"
          DESTINATION "${_asap_pc_dir}" COMPONENT development)
  set(_asap_requires "asap-core = ${PROJECT_VERSION}")  # of all but the first
  set(_asap_threads "")
endforeach()
