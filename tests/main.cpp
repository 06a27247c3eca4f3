// The main function of all test programs; that of version 3 is in Catch2's library.
#if !defined(CAGEFORM_CATCH3)
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#endif
