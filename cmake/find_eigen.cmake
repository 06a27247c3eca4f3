# Finds Eigen 3.4 or later, below 6, as find_package(Eigen3) does. Where there is none, Eigen3_FOUND is false and
# cageform_no_eigen says why.
#
# No single find_package can ask for it: a version file of Eigen denies to be of another major version, and to be in a range that
# spans two. So a version that there is not is asked for first: that takes none and names all there are, in the order of the search.
find_package(Eigen3 999 QUIET NO_MODULE)
set(cageform_no_eigen "there is no Eigen of a version from 3.4 to below 6")
foreach(cageform_config cageform_version IN ZIP_LISTS Eigen3_CONSIDERED_CONFIGS Eigen3_CONSIDERED_VERSIONS)
  if(NOT cageform_version VERSION_LESS 3.4 AND cageform_version VERSION_LESS 6)
    get_filename_component(cageform_config ${cageform_config} DIRECTORY)
    find_package(Eigen3 QUIET NO_MODULE PATHS ${cageform_config} NO_DEFAULT_PATH)
    break()
  endif()
  string(APPEND cageform_no_eigen ", only ${cageform_version} (${cageform_config})")
endforeach()
