// The connected components of a triangle mesh, and their orientation.
#pragma once

#include <cageform/cage/detail/primitives.hpp>
#include <cageform/cage/faces_of.hpp>
#include <cageform/core/detail/disjoint_sets.hpp>

#include <numbers>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T>
class TriangleMesh; // in cage/triangle_mesh.hpp

namespace detail {

struct Shells {
    std::vector<std::uint32_t> of_face;    ///< the shell of every face
    std::vector<std::uint32_t> first_face; ///< the first face of every shell
    std::vector<double> volume; ///< six times each shell's volume; positive if counter-clockwise from outside
    std::vector<bool> reversed; ///< whether faces must be flipped to be counter-clockwise from outside
};

/// Finds the connected components, numbered by their first faces; fills `of_face` and `first_face`.
template <Scalar T>
Shells connected_faces(const TriangleMesh<T>& mesh) {
    DisjointSets components(mesh.size());
    for (const auto& [a, b, c] : mesh.faces()) {
        components.join(a, b);
        components.join(a, c);
    }
    Shells shells;
    std::vector<std::uint32_t> number(mesh.size(), no_vertex);
    for (const auto& face : mesh.faces()) {
        auto& shell = number[components.find(face[0])];
        if (shell == no_vertex) {
            shell = std::uint32_t(shells.first_face.size());
            shells.first_face.push_back(std::uint32_t(shells.of_face.size()));
        }
        shells.of_face.push_back(shell);
    }
    return shells;
}

/// Counts the other shells that enclose a shell.
template <Scalar T>
std::size_t shell_depth(const TriangleMesh<T>& mesh, const Shells& shells, std::uint32_t shell) {
    if (shells.first_face.size() == 1) return 0;
    std::vector<double> winding(shells.first_face.size());
    const auto q = vec_cast<double>(mesh[mesh.faces()[shells.first_face[shell]][0]]);
    for (std::size_t f = 0; f < mesh.faces().size(); ++f) {
        const auto other = shells.of_face[f];
        if (other != shell)
            winding[other] += half_solid_angle(q, Facet<3>(mesh.faces()[f], mesh.vertices()).corner) /
                              (2 * std::numbers::pi);
    }
    return std::size_t(std::count_if(winding.begin(), winding.end(), is_enclosed));
}

/// Finds the shells of a mesh. O(#F) for one shell, O(#F · shells) for more.
template <Scalar T>
Shells shells_of(const TriangleMesh<T>& mesh) {
    Shells shells = connected_faces(mesh);
    shells.volume.resize(shells.first_face.size());
    for (std::size_t f = 0; f < mesh.faces().size(); ++f) {
        const auto shell = shells.of_face[f];
        const auto origin = vec_cast<double>(mesh[mesh.faces()[shells.first_face[shell]][0]]);
        const auto [a, b, c] = Facet<3>(mesh.faces()[f], mesh.vertices()).corner;
        shells.volume[shell] += dot(a - origin, cross(b - origin, c - origin));
    }
    for (std::uint32_t s = 0; s < shells.first_face.size(); ++s) {
        const bool is_cavity = shell_depth(mesh, shells, s) % 2 == 1;
        shells.reversed.push_back((shells.volume[s] > 0) == is_cavity);
    }
    return shells;
}

/// Returns the faces, with those of reversed shells flipped, so that all are counter-clockwise seen from
/// outside the cage. Costs as much as `shells_of`.
template <Scalar T>
std::vector<typename TriangleMesh<T>::Face> outward_faces(const TriangleMesh<T>& mesh) {
    const auto shells = shells_of(mesh);
    std::vector<typename TriangleMesh<T>::Face> faces(mesh.faces().begin(), mesh.faces().end());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if (shells.reversed[shells.of_face[f]]) std::swap(faces[f][1], faces[f][2]);
    }
    return faces;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
