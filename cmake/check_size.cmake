# cmake -DCOMPILER=… -DINCLUDE=… -DHEADER=… -DLIMIT=… -P check_size.cmake
# Preprocessed lines of a header: what every file that includes it pays.
file(WRITE check_size.cpp "#include <${HEADER}>\n")
execute_process(COMMAND ${COMPILER} -std=c++20 -I${INCLUDE} -E check_size.cpp OUTPUT_VARIABLE text RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "${HEADER} does not preprocess")
endif()
string(REGEX REPLACE "[^\n]" "" newlines "${text}")
string(LENGTH "${newlines}" lines)
message(STATUS "${HEADER}: ${lines} lines, limit ${LIMIT}")
if(lines GREATER ${LIMIT} OR lines LESS 1000)
  message(FATAL_ERROR "${HEADER} preprocesses to ${lines} lines")
endif()
