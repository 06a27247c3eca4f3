# cmake -DBUILD=… -DSOURCE=… -DCOMPILER=… -DGENERATOR=… -DMAKE_PROGRAM=… -DEIGEN_INCLUDE=… -P check_package.cmake
# Installs the project into a separate folder, then configures, builds and runs clients. One client binds, one only
# plays back without Eigen, and libraries export their dependency. The clients are configured with the CMake that runs
# this script, so an old CMake tests that version.
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

# Installs cageform alone, and together with Eigen packages of several versions. These packages use the installed headers of Eigen.
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
include(CMakePackageConfigHelpers)
foreach(version IN ITEMS 3.3.9 5.0.1 6.0.0)
  run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${work}/eigen_${version})
  set(eigen ${work}/eigen_${version}/share/eigen3/cmake)
  file(WRITE ${eigen}/Eigen3Config.cmake "add_library(Eigen3::Eigen INTERFACE IMPORTED)
set_target_properties(Eigen3::Eigen PROPERTIES INTERFACE_INCLUDE_DIRECTORIES ${EIGEN_INCLUDE})
")
  write_basic_package_version_file(${eigen}/Eigen3ConfigVersion.cmake VERSION ${version} COMPATIBILITY SameMajorVersion ARCH_INDEPENDENT)
endforeach()

# Clients: of the package with the installed Eigen, with Eigen 5 and without Eigen, and of the sources.
set(sources -DCAGEFORM_SOURCE=${SOURCE}/../..)
set(eigen_5 -DCMAKE_PREFIX_PATH=${work}/eigen_5.0.1)
foreach(client IN ITEMS "client_eigen_3;client_runtime;-DCMAKE_PREFIX_PATH=${prefix}" "client_eigen_5;client_runtime;${eigen_5}" "client_sources;client;${sources};${eigen_5}"
                        "client_runtime;client_runtime;-DCMAKE_PREFIX_PATH=${prefix};-DRUNTIME_ONLY=ON;-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON")
  list(POP_FRONT client folder name)
  set(client_build ${work}/${folder})
  run(${with_compiler} -S ${SOURCE} -B ${client_build} ${client})
  run(${CMAKE_COMMAND} --build ${client_build} --target ${name})
  run(${client_build}/${name})
  if(client MATCHES "eigen_5")
    file(STRINGS ${client_build}/CMakeCache.txt found REGEX "^Eigen3_DIR:" ENCODING UTF-8)
    if(NOT found MATCHES "eigen_5\\.0\\.1")
      message(FATAL_ERROR "${folder}: found ${found} instead of the first Eigen")
    endif()
  endif()
endforeach()

# A sub-project is not installed by default.
run(${CMAKE_COMMAND} --build ${work}/client_sources --target client_runtime)
run(${CMAKE_COMMAND} --install ${work}/client_sources --prefix ${work}/sources_installed)
file(GLOB_RECURSE installed RELATIVE ${work}/sources_installed ${work}/sources_installed/*)
if(NOT installed STREQUAL "bin/client_runtime")
  message(FATAL_ERROR "unexpected installed files: ${installed}")
endif()

# Rejects an Eigen that is too old or too new; the sources can be configured without Eigen.
foreach(version IN ITEMS 3.3.9 6.0.0)
  set(refused ${configure} -DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF -DCMAKE_FIND_USE_SYSTEM_ENVIRONMENT_PATH=OFF
              -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_MAKE_PROGRAM=${MAKE_PROGRAM})
  execute_process(COMMAND ${refused} -S ${SOURCE} -B ${work}/refused_${version} -DCMAKE_PREFIX_PATH=${work}/eigen_${version}
                  RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE errors)
  execute_process(COMMAND ${refused} -S ${SOURCE} -B ${work}/sources_refused_${version} ${sources} -DRUNTIME_ONLY=ON
                          -DCMAKE_PREFIX_PATH=${work}/eigen_${version}
                  RESULT_VARIABLE sources_failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  foreach(text IN ITEMS "${errors}" "${output}")
    string(REGEX REPLACE "[ \n]+" " " text "${text}") # CMake breaks lines
    if(NOT failed OR sources_failed OR NOT text MATCHES "no Eigen >= 3.4 and < 6, only ${version} ")
      message(FATAL_ERROR "Eigen ${version}: ${failed}, ${sources_failed}\n${text}")
    endif()
  endforeach()
endforeach()

# Rejects an unknown component.
execute_process(COMMAND ${configure} -S ${SOURCE}/consumer -B ${work}/nonsense -DCMAKE_PREFIX_PATH=${prefix} -DCOMPONENT=nonsense
                RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE errors)
if(NOT failed OR NOT errors MATCHES "no component \"nonsense\"")
  message(FATAL_ERROR "COMPONENTS nonsense: ${failed}\n${errors}")
endif()

# Libraries that link the runtime: installed, exported and found again.
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

# pkg-config with a moved prefix.
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
  message(STATUS "skipped: the pkg-config files (install pkg-config)")
endif()
