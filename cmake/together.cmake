# compile_together(TARGET): its sources are compiled six at a time, those of one folder together, so that headers
# are parsed and templates instantiated once for the six. So no two sources of a folder may give one name to
# different things, not even in unnamed namespaces. MARQUETRY_TOGETHER=OFF, as the preset debug has it,
# compiles each alone, and says what a source forgot to include.
option(MARQUETRY_TOGETHER "Compile sources of a folder together: shorter from nothing, longer after a change" ON)

function(compile_together target)
  if(NOT MARQUETRY_TOGETHER)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "\\.cpp$")
  foreach(source ${sources})
    cmake_path(ABSOLUTE_PATH source NORMALIZE OUTPUT_VARIABLE folder)
    cmake_path(REMOVE_FILENAME folder)
    cmake_path(GET folder PARENT_PATH folder)
    cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
    string(REGEX REPLACE "/(detail|shared)$" "" folder ${folder})
    string(MAKE_C_IDENTIFIER ${folder} folder)
    math(EXPR group "0${count_of_${folder}} / 6")
    math(EXPR count_of_${folder} "0${count_of_${folder}} + 1")
    set_property(SOURCE ${source} TARGET_DIRECTORY ${target} PROPERTY UNITY_GROUP ${folder}_${group})
  endforeach()
endfunction()
