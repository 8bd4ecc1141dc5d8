# cmake --install: the program, the libraries mq, mq_io and mq_model with their headers, and what find_package and
# pkg-config need to find them.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/marquetry)
set(generated ${PROJECT_BINARY_DIR}/include/mq)

configure_file(${CMAKE_CURRENT_LIST_DIR}/version.h.in ${generated}/version.h @ONLY)
configure_file(${CMAKE_CURRENT_LIST_DIR}/mq.h ${generated}/mq.h COPYONLY)

set_target_properties(mq_io PROPERTIES EXPORT_NAME io)
set_target_properties(mq_model PROPERTIES EXPORT_NAME model)
install(TARGETS mq mq_io mq_model EXPORT marquetryTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS marquetry RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(TARGET marquetry-view)
  install(TARGETS marquetry-view RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/mq DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.h" PATTERN "baseline" EXCLUDE)
install(FILES ${generated}/version.h ${generated}/mq.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/mq)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/THIRD_PARTY.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR})

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/marquetryConfig.cmake.in
  ${PROJECT_BINARY_DIR}/marquetryConfig.cmake INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/marquetryConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/marquetryConfig.cmake ${PROJECT_BINARY_DIR}/marquetryConfigVersion.cmake
  DESTINATION ${package})
install(EXPORT marquetryTargets NAMESPACE mq:: DESTINATION ${package})

set(MARQUETRY_PC_LIBS "-lembree3")
if(MARQUETRY_CHOLMOD AND CHOLMOD_INCLUDE AND CHOLMOD_LIBRARY)
  string(APPEND MARQUETRY_PC_LIBS " -lcholmod")
endif()
set(MARQUETRY_PC_CFLAGS "")
if(MARQUETRY_NATIVE)
  set(MARQUETRY_PC_CFLAGS "-march=native")
endif()
configure_file(${CMAKE_CURRENT_LIST_DIR}/marquetry.pc.in ${PROJECT_BINARY_DIR}/marquetry.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/marquetry.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
