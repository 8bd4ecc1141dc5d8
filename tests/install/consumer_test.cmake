# Installs what was built, builds the examples against it as a stranger would, and runs them.
#   cmake -D BUILD=... -D SOURCE=... -D WORK=... -P consumer_test.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nended with ${status}:\n${output}")
  endif()
  set(output ${output} PARENT_SCOPE)
endfunction()
function(expect_file)
  foreach(file ${ARGN})
    if(NOT EXISTS ${file})
      message(FATAL_ERROR "${file} is missing")
    endif()
  endforeach()
endfunction()

file(REMOVE_RECURSE ${WORK})
set(prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
expect_file(${prefix}/share/man/man1/marquetry.1 ${prefix}/share/man/man1/marquetry-filter.1
  ${prefix}/share/bash-completion/completions/marquetry ${prefix}/share/zsh/vendor-completions/_marquetry
  ${prefix}/share/fish/vendor_completions.d/marquetry.fish)
set(marquetry ${prefix}/bin/marquetry)
run(${marquetry} sample bust --misaligned --size 256 -o ${WORK}/ -q)
set(model ${WORK}/bust.obj ${WORK}/bust.png)

run(${CMAKE_COMMAND} -S ${SOURCE}/examples -B ${WORK}/examples -DCMAKE_PREFIX_PATH=${prefix}
  -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${WORK}/examples)

# The library does what the program does, to the last bit.
set(filter filter ${model} --beta 2 --length 3tx --halo inf -q)
run(${WORK}/examples/01_filter ${model} ${WORK}/example.png)
run(${marquetry} ${filter} -o ${WORK}/program.png)
run(${CMAKE_COMMAND} -E compare_files ${WORK}/example.png ${WORK}/program.png)

# Each example makes a picture.
run(${WORK}/examples/02_stitch ${model} ${WORK}/stitched.png)
run(${WORK}/examples/03_geodesic ${WORK}/bust.obj 0 ${WORK}/distance.png)
run(${marquetry} render ${model} --view 0,10 --size 240 -o ${WORK}/first.png -q)
run(${marquetry} render ${model} --view 5,10 --size 240 -o ${WORK}/second.png -q)
run(${WORK}/examples/04_flow ${WORK}/first.png ${WORK}/second.png ${WORK}/flow.png)
run(${WORK}/examples/05_track ${WORK}/tracked.png)
run(${WORK}/examples/06_unwrap ${WORK}/bust.obj ${WORK}/unwrapped.obj ${WORK}/charts.png)
expect_file(${WORK}/stitched.png ${WORK}/distance.png ${WORK}/flow.png ${WORK}/tracked.png
  ${WORK}/unwrapped.obj ${WORK}/charts.png)

# Flags of its own: a consumer for machines with AVX2 gets the same, by pkg-config this time. (Where there is
# no AVX2 it is built and not run.)
set(ENV{PKG_CONFIG_PATH} ${prefix}/lib/pkgconfig:${prefix}/lib/x86_64-linux-gnu/pkgconfig)
run(pkg-config --cflags --libs --static marquetry)
set(all_flags "${output}")
separate_arguments(flags UNIX_COMMAND "${all_flags}")
run(c++ -std=c++20 -O2 -mavx2 -mfma -ffp-contract=off ${SOURCE}/examples/01_filter.cpp -o ${WORK}/avx2 ${flags})
file(READ /proc/cpuinfo processor)
if(processor MATCHES "avx2")
  run(${WORK}/avx2 ${model} ${WORK}/avx2.png)
  run(${CMAKE_COMMAND} -E compare_files ${WORK}/avx2.png ${WORK}/program.png)
endif()

# One that aligns Eigen's types in its own way is told so.
string(REGEX REPLACE "-DEIGEN[A-Z_]*=[0-9]*" "" other "${all_flags}")
separate_arguments(other UNIX_COMMAND "${other}")
execute_process(COMMAND c++ -std=c++20 -fsyntax-only ${SOURCE}/examples/01_filter.cpp ${other}
  RESULT_VARIABLE status ERROR_VARIABLE message)
if(status EQUAL 0 OR NOT message MATCHES "pkg-config --cflags marquetry")
  message(FATAL_ERROR "a consumer without our definitions was not refused:\n${message}")
endif()
if(NOT KEEP)
  file(REMOVE_RECURSE ${WORK})
endif()
