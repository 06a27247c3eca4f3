// Compiles PoseSolver.
#include "instantiate.hpp"

#include <cageform/pose/detail/pose_solver.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

using Solver = PoseSolver<CAGEFORM_T, CAGEFORM_D>;
CAGEFORM_COMPILE Solver::PoseSolver(PoseSamples<CAGEFORM_T, CAGEFORM_D>, const PoseOptions&);
CAGEFORM_COMPILE Status Solver::set_pins(const PosePins<CAGEFORM_T, CAGEFORM_D>&);
CAGEFORM_COMPILE Status Solver::set_held(std::span<const std::uint32_t>);
CAGEFORM_COMPILE void Solver::reset() noexcept;
CAGEFORM_COMPILE void Solver::remember_pose() noexcept;
CAGEFORM_COMPILE Status Solver::check(std::size_t, std::size_t, std::size_t) const noexcept;
CAGEFORM_COMPILE PoseSolverReport Solver::refused(PoseSolverReport&, std::size_t,
                                                  const detail::RigidFrame<CAGEFORM_D>&) noexcept;
CAGEFORM_COMPILE void Solver::run(PoseSolverReport&) noexcept;
CAGEFORM_COMPILE void Solver::finish(PoseSolverReport&) noexcept;

} // namespace cageform::inline CAGEFORM_ABI
