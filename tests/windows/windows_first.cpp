// Most headers after windows.h and what programs include with it, by mingw-w64, without the definitions of
// the library. The library of mingw-w64 has neither GLM nor, in one of its thread models, threads. It
// defines neither min nor max in C++.
#include <winsock2.h>

#include <windows.h>

#include <commctrl.h>
#include <objbase.h>
#include <windowsx.h>

#include "all_headers.hpp"

#include <cageform/c/cageform.h>

#if !defined(near) || !defined(ERROR)
#error "a header has undefined the macros: this file checks nothing"
#endif

using Points = std::vector<cageform::Vec<float, 2>>;

cageform::BindReport report_of(const Points& cage, const Points& figure) {
    return cageform::bind(cageform::HarmonicCoordinates<float, 2>(cage), figure).report;
}
