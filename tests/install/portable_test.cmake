# The program on processors of other kinds, by qemu-user: without AVX it runs, and where there is no AVX-512
# it gives what the same form of its kernels gives here.
#   cmake -D PROGRAM=... -D WORK=... -P portable_test.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nended with ${status}:\n${output}")
  endif()
endfunction()

find_program(QEMU qemu-x86_64)
if(NOT QEMU)
  message(STATUS "skipped: there is no qemu-x86_64 (qemu-user)")
  return()
endif()
file(REMOVE_RECURSE ${WORK})
run(${PROGRAM} sample bust --misaligned --size 64 -o ${WORK}/ -q)
set(model ${WORK}/bust.obj ${WORK}/bust.png -q --solver multigrid)
set(filter filter ${model} --beta 2 --length 3tx)
set(geodesic geodesic ${model} --from 0,1,0)  # writes single precision, whose last bits tell forms apart
foreach(pair "Haswell;x86-64-v3" "Nehalem;x86-64")
  list(GET pair 0 cpu)
  list(GET pair 1 form)
  foreach(verb filter geodesic)
    run(${QEMU} -cpu ${cpu} ${PROGRAM} ${${verb}} -o ${WORK}/${verb}_${cpu}.exr --threads 2)
    run(${CMAKE_COMMAND} -E env MARQUETRY_INSTRUCTIONS=${form}
      ${PROGRAM} ${${verb}} -o ${WORK}/${verb}_${form}.exr)
    run(${CMAKE_COMMAND} -E compare_files ${WORK}/${verb}_${cpu}.exr ${WORK}/${verb}_${form}.exr)
  endforeach()
endforeach()
execute_process(COMMAND ${CMAKE_COMMAND} -E compare_files
  ${WORK}/geodesic_x86-64.exr ${WORK}/geodesic_x86-64-v3.exr
  RESULT_VARIABLE equal OUTPUT_QUIET ERROR_QUIET)
if(equal EQUAL 0)
  message(FATAL_ERROR "both forms give the same bits, so that this tells nothing")
endif()
file(REMOVE_RECURSE ${WORK})
