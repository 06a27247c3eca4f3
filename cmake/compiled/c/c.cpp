// Compiles the C interface.
#define CAGEFORM_C_IMPLEMENTATION
#include <cageform/c/cageform.h>
