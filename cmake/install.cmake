include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS palpate EXPORT palpate_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/palpate DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
install(FILES ${PROJECT_BINARY_DIR}/include/palpate/version.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/palpate)
install(EXPORT palpate_targets NAMESPACE palpate:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/palpate)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/palpate-config.cmake.in
  ${PROJECT_BINARY_DIR}/palpate-config.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/palpate)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/palpate-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/palpate-config.cmake ${PROJECT_BINARY_DIR}/palpate-config-version.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/palpate)

# The command, where the tools are built.
if(TARGET palpate_command)
  install(TARGETS palpate_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
