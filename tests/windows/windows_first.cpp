// Every header behind windows.h itself and what programs include with it, and a harmonic bind, by
// mingw-w64. Its library has neither GLM nor, of one of its thread models, threads. It defines neither min
// nor max in C++.
#include <winsock2.h>

#include <windows.h>

#include <commctrl.h>
#include <objbase.h>
#include <windowsx.h>

#include "all_headers.hpp"

#if !defined(near) || !defined(ERROR)
#error "a header has undefined the macros: this file checks nothing"
#endif

using Points = std::vector<cageform::Vec<float, 2>>;

cageform::BindReport report_of(const Points& cage, const Points& figure) {
    return cageform::bind(cageform::HarmonicCoordinates<float, 2>(cage), figure).report;
}
