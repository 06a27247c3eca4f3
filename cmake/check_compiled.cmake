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
build(debug "${flags} -O0 -g" failed) # a debug build with asserts, of a library without
if(failed)
  message(FATAL_ERROR "the client does not build: ${output}")
endif()
execute_process(COMMAND ${WORK}/debug/client RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(failed)
  message(FATAL_ERROR "the client: ${failed}, ${output}")
endif()
find_program(clang NAMES clang++-19 clang++) # a program by another compiler than the library's
if(clang)
  set(given ${COMPILER})
  set(COMPILER ${clang})
  build(clang "${flags}" failed)
  if(failed)
    message(FATAL_ERROR "the client by clang does not link: ${output}")
  endif()
  execute_process(COMMAND ${WORK}/clang/client RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "the client by clang: ${failed}, ${output}")
  endif()
  set(COMPILER ${given})
endif()
build(registers "${flags} -DCAGEFORM_REGISTER_BYTES=0" failed)
if(NOT failed OR NOT output MATCHES "undefined reference|undefined symbol")
  message(FATAL_ERROR "a client for other registers: ${failed}, ${output}")
endif()
