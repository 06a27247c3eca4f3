// Compiles PoseSolver.
#include "instantiate.hpp"

#include <cageform/pose/detail/pose_solver.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_POSE(T, D)                                                                                  \
    CAGEFORM_COMPILE PoseSolver<T, D>::PoseSolver(PoseSamples<T, D>, const PoseOptions&);                    \
    CAGEFORM_COMPILE Status PoseSolver<T, D>::set_pins(const PosePins<T, D>&);                               \
    CAGEFORM_COMPILE Status PoseSolver<T, D>::set_held(std::span<const std::uint32_t>);                      \
    CAGEFORM_COMPILE void PoseSolver<T, D>::reset() noexcept;                                                \
    CAGEFORM_COMPILE void PoseSolver<T, D>::remember_pose() noexcept;                                        \
    CAGEFORM_COMPILE Status PoseSolver<T, D>::check(std::size_t, std::size_t, std::size_t) const noexcept;   \
    CAGEFORM_COMPILE PoseSolverReport PoseSolver<T, D>::refused(PoseSolverReport&, std::size_t,              \
                                                                const detail::RigidFrame<D>&) noexcept;      \
    CAGEFORM_COMPILE void PoseSolver<T, D>::run(PoseSolverReport&) noexcept;                                 \
    CAGEFORM_COMPILE void PoseSolver<T, D>::finish(PoseSolverReport&) noexcept;
CAGEFORM_FOR_SCALARS(CAGEFORM_POSE, CAGEFORM_D)

} // namespace cageform::inline CAGEFORM_ABI
