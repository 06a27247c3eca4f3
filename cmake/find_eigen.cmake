# Finds Eigen >= 3.4 and < 6 like find_package(Eigen3). If there is none, Eigen3_FOUND is false and cageform_no_eigen has
# the reason.
#
# A single find_package cannot do this: version files of Eigen reject other major versions, and ranges that span two. So a
# nonexistent version is requested first, which lists all installed versions in search order.
find_package(Eigen3 999 QUIET NO_MODULE)
set(cageform_no_eigen "there is no Eigen >= 3.4 and < 6")
foreach(cageform_config cageform_version IN ZIP_LISTS Eigen3_CONSIDERED_CONFIGS Eigen3_CONSIDERED_VERSIONS)
  if(NOT cageform_version VERSION_LESS 3.4 AND cageform_version VERSION_LESS 6)
    get_filename_component(cageform_config ${cageform_config} DIRECTORY)
    find_package(Eigen3 QUIET NO_MODULE PATHS ${cageform_config} NO_DEFAULT_PATH)
    break()
  endif()
  string(APPEND cageform_no_eigen ", only ${cageform_version} (${cageform_config})")
endforeach()
