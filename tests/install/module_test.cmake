# A program that does not find its module for pictures reads plain PNG, and says of others what is missing.
#   cmake -D PROGRAM=... -D WORK=... -P module_test.cmake
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
file(COPY ${PROGRAM} DESTINATION ${WORK})
set(marquetry ${WORK}/marquetry)
foreach(arguments "--version" "sample;bust;--size;64;-o;${WORK}/bust.obj;-q"
    "filter;${WORK}/bust.obj;-b;2;-o;${WORK}/filtered.png;-q")
  execute_process(COMMAND ${marquetry} ${arguments} RESULT_VARIABLE status ERROR_VARIABLE message OUTPUT_QUIET)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${arguments} ended with ${status}:\n${message}")
  endif()
endforeach()
execute_process(COMMAND ${marquetry} filter ${WORK}/bust.obj -b 2 -o ${WORK}/filtered.tif -q
  RESULT_VARIABLE status ERROR_VARIABLE message)
if(NOT status EQUAL 2 OR NOT message MATCHES "libmarquetry_pictures.so" OR EXISTS ${WORK}/filtered.tif)
  message(FATAL_ERROR "a missing module was not told of (${status}):\n${message}")
endif()
file(REMOVE_RECURSE ${WORK})
