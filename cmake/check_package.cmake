# cmake -DBUILD=… -DSOURCE=… -DCOMPILER=… -DGENERATOR=… -P check_package.cmake
# Installs the project into a folder of its own, then configures, builds and runs clients of it: one that binds, and
# one that only plays back, on a machine without Eigen.
set(prefix ${BUILD}/package/prefix)
set(client ${BUILD}/package/client)
file(REMOVE_RECURSE ${prefix} ${client} ${client}_runtime)
set(configure ${CMAKE_COMMAND} -S ${SOURCE} -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_PREFIX_PATH=${prefix})
foreach(step IN ITEMS
    "${CMAKE_COMMAND};--install;${BUILD};--prefix;${prefix}"
    "${configure};-B;${client}"
    "${CMAKE_COMMAND};--build;${client}"
    "${client}/client"
    "${configure};-B;${client}_runtime;-DRUNTIME_ONLY=ON;-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON"
    "${CMAKE_COMMAND};--build;${client}_runtime"
    "${client}_runtime/client_runtime")
  execute_process(COMMAND ${step} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${step}:\n${output}")
  endif()
endforeach()
