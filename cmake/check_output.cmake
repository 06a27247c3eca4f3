# cmake -DPROGRAM=… -DEXPECTED=<file> -P check_output.cmake
# Runs a program and compares its output with a text file, or with the lines in a source file that begin with "//> ".
execute_process(COMMAND ${PROGRAM} RESULT_VARIABLE failed OUTPUT_VARIABLE output)
file(READ ${EXPECTED} expected)
if(EXPECTED MATCHES "\\.cpp$")
  string(ASCII 1 semicolon) # a list's elements cannot hold ";"
  string(REPLACE ";" "${semicolon}" expected "${expected}")
  string(REGEX MATCHALL "\n//>[^\n]*" lines "${expected}")
  list(JOIN lines "" expected)
  string(REGEX REPLACE "\n//> ?" "\n" expected "${expected}\n")
  string(REGEX REPLACE "^\n" "" expected "${expected}")
  string(REPLACE "${semicolon}" ";" expected "${expected}")
endif()
if(failed OR expected STREQUAL "" OR NOT output STREQUAL expected)
  message(FATAL_ERROR "exit ${failed}; printed:\n${output}expected:\n${expected}")
endif()
