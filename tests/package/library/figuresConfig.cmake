include(CMakeFindDependencyMacro)
find_dependency(cageform 0.1 COMPONENTS runtime)
include(${CMAKE_CURRENT_LIST_DIR}/figuresTargets.cmake)
