# cmake -DBUILD=… -DSOURCE=… -DCOMPILER=… -DGENERATOR=… -P check_package.cmake
# Installs the project into a folder of its own, then configures, builds and runs a client of it.
set(prefix ${BUILD}/package/prefix)
set(client ${BUILD}/package/client)
file(REMOVE_RECURSE ${prefix} ${client})
foreach(step IN ITEMS
    "${CMAKE_COMMAND};--install;${BUILD};--prefix;${prefix}"
    "${CMAKE_COMMAND};-S;${SOURCE};-B;${client};-G;${GENERATOR};-DCMAKE_CXX_COMPILER=${COMPILER};-DCMAKE_PREFIX_PATH=${prefix}"
    "${CMAKE_COMMAND};--build;${client}"
    "${client}/client")
  execute_process(COMMAND ${step} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${step}:\n${output}")
  endif()
endforeach()
