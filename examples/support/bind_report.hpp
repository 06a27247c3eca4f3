#pragma once

// The library's reports in words.

#include <cageform/binding/bind.hpp>

#include <string>

namespace cageform_examples {

/// "edges cross or touch (3, 7)", with only the numbers that mean something.
std::string describe_fault(const cageform::CageFault& fault);

/// One line per fault of the cage that prevents a bind: "cat_cage.svg: edges cross or touch (3, 7)".
std::string describe_faults(const std::string& name, const cageform::BindReport& report);

/// The report of a bind for people.
std::string describe(const cageform::BindReport& report);

} // namespace cageform_examples
