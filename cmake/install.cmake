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
install(TARGETS mq mq_io mq_model EXPORT marquetryTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  COMPONENT development)

# What reads and writes pictures is found by the run path of whatever is linked with mq_io.
set(modules ${CMAKE_INSTALL_LIBDIR}/marquetry)
install(TARGETS mq_pictures LIBRARY DESTINATION ${modules} COMPONENT program)
if(TARGET marquetry_scratch)
  install(TARGETS marquetry_scratch LIBRARY DESTINATION ${modules} COMPONENT program)
endif()
target_link_options(mq_io INTERFACE $<INSTALL_INTERFACE:-Wl,-rpath,$<INSTALL_PREFIX>/${modules}>)
file(RELATIVE_PATH modules_from_programs /${CMAKE_INSTALL_BINDIR} /${modules})
set(programs marquetry)
if(TARGET marquetry-view)
  list(APPEND programs marquetry-view)
endif()
set_target_properties(${programs} PROPERTIES INSTALL_RPATH $ORIGIN/${modules_from_programs})
install(TARGETS marquetry RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
if(TARGET marquetry-view)
  install(TARGETS marquetry-view RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/mq DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development
  FILES_MATCHING PATTERN "*.h" PATTERN "baseline" EXCLUDE PATTERN "embree.h" EXCLUDE
  # Those that include OpenImageIO, which programs on top of the library need not have.
  PATTERN "picture_alpha.h" EXCLUDE PATTERN "picture_head.h" EXCLUDE PATTERN "picture_reader.h" EXCLUDE PATTERN "picture_webp.h" EXCLUDE)
install(FILES ${generated}/version.h ${generated}/mq.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/mq
  COMPONENT development)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/THIRD_PARTY.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)

# Manual pages and completions, which the program makes from its option tables.
set(words ${PROJECT_BINARY_DIR}/words)
file(GLOB verbs CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/apps/marquetry/verbs/*.cpp)
list(TRANSFORM verbs REPLACE ".*/(.*)\\.cpp" "\\1")
add_custom_command(OUTPUT ${words}/made DEPENDS marquetry ${CMAKE_CURRENT_LIST_DIR}/words.cmake
  COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:marquetry> "-DVERBS=${verbs}" -D WORDS=${words}
    -P ${CMAKE_CURRENT_LIST_DIR}/words.cmake
  COMMENT "Manual pages and completions" VERBATIM)
add_custom_target(marquetry_words ALL DEPENDS ${words}/made)
# Where only some targets were built they are made now.
install(CODE "execute_process(COMMAND \"${CMAKE_COMMAND}\" --build \"${PROJECT_BINARY_DIR}\"
  --target marquetry_words COMMAND_ERROR_IS_FATAL ANY)" COMPONENT program)
install(DIRECTORY ${words}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT program)
install(FILES ${words}/completions/marquetry COMPONENT program
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${words}/completions/_marquetry COMPONENT program
  DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(FILES ${words}/completions/marquetry.fish COMPONENT program
  DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/marquetryConfig.cmake.in
  ${PROJECT_BINARY_DIR}/marquetryConfig.cmake INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/marquetryConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/marquetryConfig.cmake ${PROJECT_BINARY_DIR}/marquetryConfigVersion.cmake
  DESTINATION ${package} COMPONENT development)
install(EXPORT marquetryTargets NAMESPACE mq:: DESTINATION ${package} COMPONENT development)

set(MARQUETRY_PC_LIBS "-lembree${EMBREE_VERSION_MAJOR} -lmeshoptimizer")
if(MARQUETRY_CHOLMOD AND CHOLMOD_INCLUDE AND CHOLMOD_LIBRARY)
  string(APPEND MARQUETRY_PC_LIBS " -lcholmod")
endif()
get_target_property(definitions mq INTERFACE_COMPILE_DEFINITIONS)
list(TRANSFORM definitions PREPEND "-D" OUTPUT_VARIABLE MARQUETRY_PC_CFLAGS)
list(JOIN MARQUETRY_PC_CFLAGS " " MARQUETRY_PC_CFLAGS)
file(RELATIVE_PATH MARQUETRY_PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(${CMAKE_CURRENT_LIST_DIR}/marquetry.pc.in ${PROJECT_BINARY_DIR}/marquetry.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/marquetry.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
  COMPONENT development)
