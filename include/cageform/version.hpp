// cageform: the one place where the version is written; CMake reads it from here.
#pragma once

#define CAGEFORM_VERSION_MAJOR 0
#define CAGEFORM_VERSION_MINOR 1
#define CAGEFORM_VERSION_PATCH 0
#define CAGEFORM_VERSION_STRING "0.1.0"
