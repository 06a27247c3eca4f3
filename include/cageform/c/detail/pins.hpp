// The samples object of the C interface.
#pragma once

#include <cageform/c/detail/objects.hpp>
#include <cageform/pose/types/pose_samples.hpp>

struct cageform_samples : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::samples;

    cageform::detail::c::OfAnyType<cageform::PoseSamples> samples;
};
