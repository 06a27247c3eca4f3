# cmake -DBUILD=… -DSOURCE=… -DCOMPILER=… -DGENERATOR=… -P check_package.cmake
# Installs the project into a folder of its own, then configures, builds and runs clients of it: one that binds, one that only
# plays back, on a machine without Eigen, and libraries that export what they link. Run by an old CMake, it shows that one works.
set(work ${BUILD}/package)
file(REMOVE_RECURSE ${work})
set(prefix ${work}/prefix)
set(configure ${CMAKE_COMMAND} -G ${GENERATOR})
set(with_compiler ${configure} -DCMAKE_CXX_COMPILER=${COMPILER})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${ARGN}:\n${output}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
foreach(client IN ITEMS "client" "client_runtime;-DRUNTIME_ONLY=ON;-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON")
  list(POP_FRONT client name)
  run(${with_compiler} -S ${SOURCE} -B ${work}/${name} -DCMAKE_PREFIX_PATH=${prefix} ${client})
  run(${CMAKE_COMMAND} --build ${work}/${name})
  run(${work}/${name}/${name})
endforeach()

# A component that there is not is refused with the reason.
execute_process(COMMAND ${configure} -S ${SOURCE}/consumer -B ${work}/nonsense -DCMAKE_PREFIX_PATH=${prefix} -DCOMPONENT=nonsense
                RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE errors)
if(NOT failed OR NOT errors MATCHES "no component \"nonsense\"")
  message(FATAL_ERROR "COMPONENTS nonsense: ${failed}\n${errors}")
endif()

# Libraries that link the runtime, by each way to have it: installed, exported and found again.
foreach(from IN ITEMS package subdirectory fetch)
  set(library ${work}/${from})
  run(${with_compiler} -S ${SOURCE}/library -B ${library} -DCAGEFORM_FROM=${from} -DCAGEFORM_SOURCE=${SOURCE}/../..
      -DCMAKE_PREFIX_PATH=${prefix})
  run(${CMAKE_COMMAND} --install ${library} --prefix ${library}/installed)
  set(found_in ${library}/installed)
  if(from STREQUAL "package")
    list(APPEND found_in ${prefix})
  endif()
  list(JOIN found_in "\\;" found_in)
  run(${configure} -S ${SOURCE}/consumer -B ${library}/consumer "-DCMAKE_PREFIX_PATH=${found_in}")
endforeach()

# pkg-config, of a prefix that was moved.
find_program(PKG_CONFIG NAMES pkg-config pkgconf)
if(PKG_CONFIG)
  file(RENAME ${prefix} ${work}/moved)
  set(ENV{PKG_CONFIG_PATH} ${work}/moved/share/pkgconfig)
  foreach(name IN ITEMS cageform-runtime cageform)
    execute_process(COMMAND ${PKG_CONFIG} --cflags ${name} RESULT_VARIABLE failed OUTPUT_VARIABLE flags ERROR_VARIABLE flags
                    OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(failed)
      message(FATAL_ERROR "pkg-config --cflags ${name}: ${flags}")
    endif()
    separate_arguments(flags UNIX_COMMAND "${flags}")
    set(flags_of_${name} ${flags})
  endforeach()
  run(${COMPILER} -std=c++20 -E -o ${work}/preprocessed ${flags_of_cageform-runtime} ${SOURCE}/runtime.cpp)
  run(${COMPILER} -std=c++20 -E -o ${work}/preprocessed ${flags_of_cageform} ${SOURCE}/main.cpp)
else()
  message(STATUS "no pkg-config: what it reads is not checked")
endif()
