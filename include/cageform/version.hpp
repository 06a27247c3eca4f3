// The version of cageform, defined only here; CMake reads it from this file.
#pragma once

#define CAGEFORM_VERSION_MAJOR 0
#define CAGEFORM_VERSION_MINOR 2
#define CAGEFORM_VERSION_PATCH 0
#define CAGEFORM_VERSION_STRING "0.2.0"
