// The functions that rewritten headers call at a mutant; run.py puts this before all of a test program.
#pragma once

#include <cstdlib>
#include <type_traits>

inline unsigned char cageform_mutants_reached[CAGEFORM_MUTANTS];
inline const int cageform_mutant_alive = std::getenv("MUTANT") ? std::atoi(std::getenv("MUTANT")) : 0;

/// Whether this mutant is the one alive; it counts as reached. None is where the compiler computes.
constexpr bool cageform_mutant(int number) noexcept {
    if (std::is_constant_evaluated()) return false;
    cageform_mutants_reached[number] = 1;
    return cageform_mutant_alive == number;
}
