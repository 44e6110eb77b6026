include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(PALPATE_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/palpate)
set(BUILD_SHARED_LIBS "${BUILD_SHARED_LIBS}")
if(NOT BUILD_SHARED_LIBS)
  set(BUILD_SHARED_LIBS OFF)
endif()

install(TARGETS palpate EXPORT palpate_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/palpate DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.hpp" PATTERN io EXCLUDE)
install(FILES ${PROJECT_BINARY_DIR}/include/palpate/version.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/palpate)
install(EXPORT palpate_targets NAMESPACE palpate:: DESTINATION ${PALPATE_PACKAGE_DIR})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/palpate-config.cmake.in
  ${PROJECT_BINARY_DIR}/palpate-config.cmake INSTALL_DESTINATION ${PALPATE_PACKAGE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/palpate-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/palpate-config.cmake ${PROJECT_BINARY_DIR}/palpate-config-version.cmake
  DESTINATION ${PALPATE_PACKAGE_DIR})

# Readers of mesh files, where they are built: palpate::io.
if(TARGET palpate_io)
  install(TARGETS palpate_io EXPORT palpate_io_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/palpate/io DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/palpate
    FILES_MATCHING PATTERN "*.hpp")
  install(EXPORT palpate_io_targets NAMESPACE palpate:: DESTINATION ${PALPATE_PACKAGE_DIR})
endif()

# pkg-config. A shared library has what it needs in itself; a static one asks who links it.
file(RELATIVE_PATH PALPATE_PREFIX_FROM_PC /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
set(PALPATE_PC_REQUIRES Requires)
set(PALPATE_PC_LIBS "Libs")
set(PALPATE_IO_PC_REQUIRES "palpate = ${PROJECT_VERSION}, zlib")
set(PALPATE_IO_PC_PRIVATE "")
if(BUILD_SHARED_LIBS)
  set(PALPATE_PC_REQUIRES Requires.private)
  set(PALPATE_PC_LIBS Libs.private)
  set(PALPATE_IO_PC_REQUIRES "palpate = ${PROJECT_VERSION}")
  set(PALPATE_IO_PC_PRIVATE zlib)
endif()
configure_file(${PROJECT_SOURCE_DIR}/cmake/palpate.pc.in ${PROJECT_BINARY_DIR}/palpate.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/palpate.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
if(TARGET palpate_io)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/palpate-io.pc.in ${PROJECT_BINARY_DIR}/palpate-io.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/palpate-io.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endif()

# The command, with its manual pages and completions, where the tools are built.
if(TARGET palpate_command)
  install(TARGETS palpate_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  # Not those of programs that are not installed.
  install(DIRECTORY ${PROJECT_BINARY_DIR}/shell/man1 DESTINATION ${CMAKE_INSTALL_MANDIR}
    REGEX "/palpate-bench-(peers|speed|step)[.]1$" EXCLUDE)
  install(FILES ${PROJECT_BINARY_DIR}/shell/palpate DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(FILES ${PROJECT_BINARY_DIR}/shell/_palpate DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
  install(FILES ${PROJECT_BINARY_DIR}/shell/palpate.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
endif()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
