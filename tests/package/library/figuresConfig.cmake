include(CMakeFindDependencyMacro)
find_dependency(cageform 0.2 COMPONENTS runtime)
include(${CMAKE_CURRENT_LIST_DIR}/figuresTargets.cmake)
