# Installs what was built, builds the examples against it as a stranger would, and runs them.
#   cmake -D BUILD=... -D SOURCE=... -D WORK=... -D PROGRAM=... -P consumer_test.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nended with ${status}:\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE}/examples -B ${WORK}/examples -DCMAKE_PREFIX_PATH=${WORK}/prefix
  -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${WORK}/examples)
run(${WORK}/prefix/bin/marquetry sample bust --misaligned --size 256 -o ${WORK}/ -q)
run(${WORK}/examples/01_filter ${WORK}/bust.obj ${WORK}/bust.png ${WORK}/example.png)
# The library does what the program does, to the last bit.
run(${WORK}/prefix/bin/marquetry filter ${WORK}/bust.obj ${WORK}/bust.png --beta 2 --length 3tx
  -o ${WORK}/program.png -q)
run(${CMAKE_COMMAND} -E compare_files ${WORK}/example.png ${WORK}/program.png)
file(REMOVE_RECURSE ${WORK})
