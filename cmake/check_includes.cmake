# cmake -DROOT=<project> -P check_includes.cmake
# Table of the includes allowed for each room of include/cageform. Includes point only to the left in
#   core -> cage -> grid -> coordinates -> binding -> clone -> pose        core -> animate -> binding/figure.hpp
#   binding/types/skin_weights.hpp, animate/curves/rigid_motion.hpp -> skeleton
# Only the C interface includes pose, enclose, fields, papers, exchange and skeleton.
set(allowed_core core config)
set(allowed_adapt core)
set(allowed_cage core config cage)
set(allowed_grid core config cage grid)
set(allowed_coordinates core config cage grid coordinates)
set(allowed_binding core cage grid coordinates binding)
set(allowed_clone core binding/binding.hpp binding/detail/packed_binding.hpp binding/types/blob.hpp binding/figure.hpp clone)
set(allowed_pose core binding/binding.hpp binding/detail/packed_binding.hpp binding/types/blob.hpp clone pose)
# Bind-time headers of pose/: they make samples for a PoseSolver, which does not include them.
set(pose_bind_time pose/pose_samples.hpp pose/types/pose_sample_options.hpp pose/detail/pose_sampler.hpp
                   pose/detail/sample_lattice.hpp pose/detail/sample_clusters.hpp pose/detail/sample_sums.hpp
                   pose/detail/column_products.hpp pose/detail/column_products.impl.hpp)
foreach(header IN LISTS pose_bind_time)
  set(allowed_${header} core cage grid coordinates binding ${pose_bind_time} pose/types/pose_samples.hpp
                         pose/types/pose_blob.hpp)
endforeach()
set(allowed_animate core config animate)
set(allowed_enclose core config cage enclose)
set(allowed_fields core cage grid fields)
set(allowed_papers core cage grid coordinates papers)
set(allowed_skeleton core config cage/triangle_mesh.hpp binding/types/skin_weights.hpp pose/detail/nearest_rotation.hpp
                     animate/curves/rigid_motion.hpp skeleton)
set(allowed_exchange core animate exchange)
set(allowed_c core version cage grid coordinates binding clone pose animate enclose skeleton c)
# Run-time headers must not include bind-time ones.
set(runtime_headers binding/binding.hpp binding/detail/packed_binding.hpp binding/types/blob.hpp binding/detail/figure_parts.hpp
          binding/detail/figure_opener.hpp binding/types/no_vectors.hpp binding/figure.hpp)
foreach(header IN LISTS runtime_headers)
  set(allowed_${header} core ${runtime_headers})
endforeach()
foreach(header IN ITEMS binding/figure.hpp binding/detail/figure_opener.hpp) # figures contain clips
  list(APPEND allowed_${header} animate/clip_blob.hpp)
endforeach()
# Third-party headers, by folder.
set(third_party_adapt Eigen/ glm/)
set(third_party_binding Eigen/)
set(third_party_skeleton Eigen/)
set(third_party_pose/detail/column_products.impl.hpp Eigen/)
set(third_party_fields/detail/graph_factors.hpp Eigen/)
set(third_party_fields/detail/elimination.hpp Eigen/)
# Standard headers with 27,000 preprocessed lines or more, forbidden at run time.
set(heavy algorithm functional iostream memory random ranges complex regex map unordered_map thread)
set(light_folders core clone ${runtime_headers} animate/curves/piecewise_cubic.hpp animate/detail/quantised_cubic.hpp animate/curves/curve_bank.hpp
                  animate/detail/extrapolation.hpp animate/curves/track.hpp animate/curves/rigid_motion.hpp animate/clip.hpp
                  animate/clip_blob.hpp animate/detail/clip_tables.hpp animate/types/clip_header.hpp
                  pose/pose_solver.hpp pose/detail/pose_solver.impl.hpp pose/types/pose_solver.hpp pose/types/pose_samples.hpp pose/types/pose_blob.hpp
                  pose/detail/axis_vectors.hpp
                  pose/detail/nearest_rotation.hpp pose/detail/stretches.hpp pose/detail/cholesky.hpp pose/detail/anderson.hpp
                  pose/detail/pin_rows.hpp pose/detail/rigid_frame.hpp pose/detail/rotation_pass.hpp pose/detail/pose_system.hpp)
set(exempt_from_light core/threads.hpp core/running.hpp core/detail/in_parallel.hpp core/types/solver_report.hpp core/affine/compensated_sum.hpp)

cmake_policy(VERSION 3.25)
set(checked 0)
file(GLOB_RECURSE headers RELATIVE ${ROOT}/include/cageform ${ROOT}/include/cageform/*/*.hpp)
foreach(header IN LISTS headers)
  string(REGEX MATCH "^[^/]+" folder ${header})
  set(key ${folder})
  if(DEFINED allowed_${header})
    set(key ${header})
  endif()
  if(NOT DEFINED allowed_${key})
    message(SEND_ERROR "${header}: the folder ${folder} is not in the table")
    continue()
  endif()
  file(STRINGS ${ROOT}/include/cageform/${header} lines REGEX "^#include")
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "^#include [<\"]([^>\"]+)[>\"].*" "\\1" name "${line}")
    math(EXPR checked "${checked} + 1")
    if(name MATCHES "^cageform/(.*)")
      set(target ${CMAKE_MATCH_1})
      set(ok FALSE)
      foreach(prefix IN LISTS allowed_${key})
        if(target MATCHES "^${prefix}(/|\\.hpp|$)" OR target STREQUAL prefix)
          set(ok TRUE)
        endif()
      endforeach()
      if(NOT ok)
        message(SEND_ERROR "${header} may not include ${target}")
      endif()
    elseif(name MATCHES "/" OR name MATCHES "\\.h$")
      set(ok FALSE)
      foreach(prefix IN LISTS third_party_${folder} third_party_${header})
        if(name MATCHES "^${prefix}" AND NOT header IN_LIST light_folders)
          set(ok TRUE)
        endif()
      endforeach()
      if(name STREQUAL "sys/mman.h" AND header STREQUAL "core/detail/huge_pages.hpp")
        set(ok TRUE)
      endif()
      if(name MATCHES "^[ei]mmintrin.h$" AND header STREQUAL "core/detail/simd_instructions.hpp")
        set(ok TRUE)
      endif()
      if(NOT ok)
        message(SEND_ERROR "${header} may not include ${name}")
      endif()
    elseif((folder IN_LIST light_folders OR header IN_LIST light_folders) AND NOT header IN_LIST exempt_from_light
           AND name IN_LIST heavy)
      message(SEND_ERROR "${header} is a run-time header and may not include <${name}>")
    endif()
  endforeach()
endforeach()
# Limits the length of files.
file(GLOB_RECURSE headers RELATIVE ${ROOT} ${ROOT}/include/cageform/*.hpp)
foreach(header IN LISTS headers)
  file(READ ${ROOT}/${header} text)
  string(REGEX REPLACE "[^\n]" "" line_ends "${text}")
  string(LENGTH "${line_ends}" lines)
  if(lines GREATER 450)
    message(SEND_ERROR "${header} has ${lines} lines: split it by job")
  endif()
endforeach()

# The support library of the examples: a room may include itself and the rooms before it.
set(rooms_before)
foreach(room IN ITEMS io svg files splats cli pictures)
  list(APPEND rooms_before ${room})
  string(JOIN "|" allowed ${rooms_before})
  file(GLOB sources ${ROOT}/examples/support/${room}/*.?pp)
  foreach(source IN LISTS sources)
    file(STRINGS ${source} lines REGEX "^#include \"")
    foreach(line IN LISTS lines)
      math(EXPR checked "${checked} + 1")
      if(NOT line MATCHES "^#include \"(${allowed})/")
        message(SEND_ERROR "${source}: the room ${room} may not have ${line}")
      endif()
    endforeach()
  endforeach()
endforeach()

if(checked LESS 50)
  message(FATAL_ERROR "only ${checked} includes found: the check does not work")
endif()
message(STATUS "${checked} includes follow the table")
