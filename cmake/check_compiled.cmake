# cmake -DBUILD=… -DSOURCE=… -DWORK=… -DCOMPILER=… -DGENERATOR=… -P check_compiled.cmake
# Installs a build with cageform::compiled, then builds and runs a client of the library, without Eigen, with the flags of that
# build, and one by clang where it is installed. With flags for other registers the client must not link, whatever its
# optimisation.
file(REMOVE_RECURSE ${WORK})
file(STRINGS ${BUILD}/CMakeCache.txt flags REGEX "^CMAKE_CXX_FLAGS:")
string(REGEX REPLACE "^CMAKE_CXX_FLAGS:[A-Z]*=(.*)$" "\\1" flags "${flags}")
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix RESULT_VARIABLE failed OUTPUT_VARIABLE output
                ERROR_VARIABLE output)
if(failed)
  message(FATAL_ERROR "install: ${output}")
endif()
function(build client flags result)
  execute_process(COMMAND ${CMAKE_COMMAND} -G ${GENERATOR} -S ${SOURCE} -B ${WORK}/${client} -DCOMPILED=ON -DCMAKE_BUILD_TYPE=
                          -DCMAKE_CXX_COMPILER=${COMPILER} "-DCMAKE_CXX_FLAGS=${flags}" -DCMAKE_PREFIX_PATH=${WORK}/prefix
                          -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON
                  RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${client}: ${output}")
  endif()
  execute_process(COMMAND ${CMAKE_COMMAND} --build ${WORK}/${client} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  set(${result} "${failed}" PARENT_SCOPE)
  set(output "${output}" PARENT_SCOPE)
endfunction()
function(build_and_run client flags)
  build(${client} "${flags}" failed)
  if(failed)
    message(FATAL_ERROR "the client ${client} does not build: ${output}")
  endif()
  execute_process(COMMAND ${WORK}/${client}/client RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "the client ${client}: ${failed}, ${output}")
  endif()
endfunction()
build_and_run(debug "${flags} -O0 -g") # a debug build with asserts, of a library without
find_program(clang NAMES clang++-19 clang++)
if(clang) # a program by another compiler than the library's
  set(given ${COMPILER})
  set(COMPILER ${clang})
  build_and_run(clang "${flags}")
  set(COMPILER ${given})
endif()
build(registers "${flags} -DCAGEFORM_REGISTER_BYTES=0" failed)
if(NOT failed OR NOT output MATCHES "undefined reference|undefined symbol")
  message(FATAL_ERROR "a client for other registers: ${failed}, ${output}")
endif()
