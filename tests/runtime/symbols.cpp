// The functions that an engine calls every frame, and nothing else: cmake/check_symbols.cmake checks the
// compiled code.
#include <cageform/clone/clone_transposed.hpp>
#include <cageform/pose/pose_solver.hpp>
#include <cageform/runtime.hpp>

namespace frame {

using namespace cageform;

template <class T, std::size_t D>
using Points = std::span<Vec<T, D>>;

template <class T, std::size_t D>
Status move(const Binding<T, D>& dense, std::span<const std::byte> file, const CageClip<T, D>& clip,
            typename CageClip<T, D>::Cursor& cursor, T time, Points<T, D> pose, Points<T, D> out,
            StridedPoints<T, D> strided, const CloneOptions<T>& options) noexcept {
    clip.sample(time, cursor, pose);
    const auto blob = open_blob<T, D>(file);
    Status status = blob.status();
    if (status == Status::ok) status = clone(dense, pose, out, options);
    if (status == Status::ok) status = clone(blob.value, pose, strided, options);
    if (status == Status::ok) status = clone_rational(blob.value, pose, {}, out);
    if (status == Status::ok) status = clone_rational(rational_view(dense).value, pose, {}, out);
    if (status == Status::ok) status = clone_transposed(dense, out, pose, options);
    if (status == Status::ok) status = clone_transposed(blob.value, strided, pose, options);
    return status;
}
template <class T>
Status turn(const Binding<T, 3>& dense, const PackedBindingView<T, 3>& packed, Points<T, 3> pose,
            Points<T, 3> normals, Points<T, 3> tangents, const StridedMatrices<T, 3>& jacobians) noexcept {
    Status status = clone_normals(std::array{packed, packed}, pose, normals);
    const std::array<BindingView<T, 3>, 3> columns{dense.view(), dense.view(), dense.view()};
    if (status == Status::ok)
        status = clone_tangent_frames(std::array{columns[0], columns[1]}, pose, normals, tangents);
    if (status == Status::ok) status = clone_jacobians(columns, pose, jacobians);
    if (status == Status::ok) status = clone_jacobians_transposed(columns, jacobians, pose);
    if (status == Status::ok)
        status = clone_normals_transposed(std::array{packed, packed}, pose, normals, tangents);
    return status;
}
template <class T>
Status play(std::span<const std::byte> file, T time, CurveCursor<T>& cursor, Points<T, 3> pose,
            Points<T, 3> out, Points<T, 3> normals, std::span<std::array<T, 4>> tangents) noexcept {
    const auto opened = cageform::open<T, 3>(file);
    if (opened.status() != Status::ok || opened.value.find_handle("hand") == 0) return opened.status();
    const std::size_t clip = opened.value.find_clip("walk");
    if (clip == opened.value.clip_count()) return opened.status();
    if (time == T(0)) opened.value.clip(clip).start(cursor);
    opened.value.clip(clip).sample(time, cursor, pose);
    return clone(opened.value, pose, FigureOutput{out, normals, tangents});
}

template <class T, std::size_t D>
PoseSolverReport pull(PoseSolver<T, D>& solver, std::span<const Vec<T, D>> targets,
                      Points<T, D> pose) noexcept {
    return solver.solve(targets, pose);
}

#define CAGEFORM_TEST_MOVE(T, D)                                                                             \
    template Status move<T, D>(const Binding<T, D>&, std::span<const std::byte>, const CageClip<T, D>&,      \
                               CageClip<T, D>::Cursor&, T, Points<T, D>, Points<T, D>, StridedPoints<T, D>,  \
                               const CloneOptions<T>&) noexcept;
CAGEFORM_TEST_MOVE(float, 2)
CAGEFORM_TEST_MOVE(double, 3)
template Status turn<float>(const Binding<float, 3>&, const PackedBindingView<float, 3>&, Points<float, 3>,
                            Points<float, 3>, Points<float, 3>, const StridedMatrices<float, 3>&) noexcept;
template Status play<float>(std::span<const std::byte>, float, CurveCursor<float>&, Points<float, 3>,
                            Points<float, 3>, Points<float, 3>, std::span<std::array<float, 4>>) noexcept;
template PoseSolverReport pull<double, 2>(PoseSolver<double, 2>&, std::span<const Vec<double, 2>>,
                                          Points<double, 2>) noexcept;
template PoseSolverReport pull<float, 3>(PoseSolver<float, 3>&, std::span<const Vec<float, 3>>,
                                         Points<float, 3>) noexcept;

Status upload(const PackedBindingView<float, 3>& binding, Points<float, 3> pose,
              std::span<std::array<float, 4>> out) {
    return write_displacements(binding, pose, out);
}
const char* shader(int part) {
    return part == 0 ? glsl::displacements : part == 1 ? glsl::blob : part == 2 ? glsl::compute : glsl::skin;
}
const char* name(Status status) {
    return to_string(status);
}

} // namespace frame
