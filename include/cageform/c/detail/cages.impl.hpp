// Makes the library's cages and coordinates of the C interface's descriptions. cages.hpp includes it, unless
// the program links cageform::compiled.
#pragma once

#include <cageform/c/detail/cages.hpp>
#include <cageform/cage/cell_complex.hpp>
#include <cageform/cage/curved/curved_polygon.hpp>
#include <cageform/cage/point_set.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/blended.hpp>
#include <cageform/coordinates/curved_green.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/lattice.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/sibson.hpp>
#include <cageform/coordinates/three_point.hpp>

namespace cageform::inline CAGEFORM_ABI::detail::c {

/// Copies numbers that describe something; null is none.
inline cageform_status copy_numbers(const std::uint32_t* numbers, std::size_t count,
                                    std::vector<std::size_t>& copied) {
    if (numbers == nullptr && count > 0) return CAGEFORM_ARGUMENT_NULL;
    if (numbers != nullptr) copied.assign(numbers, numbers + count);
    return CAGEFORM_OK;
}
/// Whether runs of `sizes` together are `count`; sums do not overflow, for sizes have 32 bits.
inline bool add_up(const std::vector<std::size_t>& sizes, std::size_t count) noexcept {
    std::size_t sum = 0;
    for (const std::size_t size : sizes) {
        sum += size;
        if (sum > count) return false;
    }
    return sum == count;
}

/// Copies the vertices of the boundary, which those of cells follow.
template <class T, std::size_t D>
cageform_status copy_boundary(const cageform_cage& cage, std::vector<Vec<T, D>>& vertices) {
    if (cage.cell_vertices > cage.vertices.count) return CAGEFORM_COUNTS_DO_NOT_MATCH;
    const cageform_status status = copy_points(cage.vertices, vertices);
    vertices.resize(vertices.size() - (status == CAGEFORM_OK ? cage.cell_vertices : 0));
    return status;
}

template <class T>
cageform_status polygon_of(const cageform_cage& cage, Polygon<T>& polygon) {
    std::vector<Vec<T, 2>> vertices;
    std::vector<std::size_t> sizes;
    cageform_status status = copy_boundary(cage, vertices);
    if (status == CAGEFORM_OK) status = copy_numbers(cage.counts, cage.count_count, sizes);
    if (status == CAGEFORM_OK) polygon = Polygon<T>(vertices, sizes);
    return status;
}

template <class T>
cageform_status curves_of(const cageform_cage& cage, CurvedPolygon<T>& polygon) {
    std::vector<Vec<T, 2>> points;
    std::vector<std::size_t> degrees, loops;
    cageform_status status = copy_points(cage.vertices, points);
    if (status == CAGEFORM_OK) status = copy_numbers(cage.counts, cage.count_count, degrees);
    if (status == CAGEFORM_OK) status = copy_numbers(cage.loops, cage.loop_count, loops);
    if (status != CAGEFORM_OK) return status;
    if (loops.empty()) loops.push_back(degrees.size());
    std::vector<std::size_t> sizes = degrees;
    for (std::size_t& size : sizes) ++size;
    if (!add_up(sizes, points.size()) || !add_up(loops, degrees.size())) return CAGEFORM_COUNTS_DO_NOT_MATCH;
    std::vector<typename CurvedPolygon<T>::Loop> made;
    auto point = points.begin();
    auto size = sizes.begin();
    for (const std::size_t edges : loops) {
        auto& loop = made.emplace_back();
        for (std::size_t e = 0; e < edges; ++e, ++size) {
            loop.emplace_back(point, point + std::ptrdiff_t(*size));
            point += std::ptrdiff_t(*size);
        }
    }
    polygon = CurvedPolygon<T>(std::move(made));
    return CAGEFORM_OK;
}

/// Calls use(mesh) with a TriangleMesh where all faces are triangles, else with a PolyhedralMesh.
template <class T, class Use>
cageform_status with_mesh(const cageform_cage& cage, const Use& use) {
    std::vector<Vec<T, 3>> vertices;
    std::vector<std::size_t> sizes;
    cageform_status status = copy_boundary(cage, vertices);
    if (status == CAGEFORM_OK) status = copy_numbers(cage.counts, cage.count_count, sizes);
    if (status != CAGEFORM_OK) return status;
    if (cage.indices == nullptr && cage.index_count > 0) return CAGEFORM_ARGUMENT_NULL;
    if (cage.counts == nullptr && cage.index_count % 3 != 0) return CAGEFORM_COUNTS_DO_NOT_MATCH;
    if (cage.counts != nullptr && !add_up(sizes, cage.index_count)) return CAGEFORM_COUNTS_DO_NOT_MATCH;
    bool triangles = cage.divisions <= 1;
    for (const std::size_t size : sizes) triangles = triangles && size == 3;
    const std::uint32_t* corner = cage.indices;
    if (triangles) {
        std::vector<std::array<std::uint32_t, 3>> faces(cage.index_count / 3);
        for (auto& face : faces) {
            for (std::uint32_t& vertex : face) vertex = *corner++;
        }
        return use(TriangleMesh<T>(vertices, faces));
    }
    if (cage.counts == nullptr) sizes.assign(cage.index_count / 3, 3);
    std::vector<std::vector<std::uint32_t>> faces;
    for (const std::size_t size : sizes) {
        faces.emplace_back(corner, corner + size);
        corner += size;
    }
    PolyhedralOptions options;
    options.off_plane = cage.off_plane;
    options.non_planar = PolyhedralOptions::NonPlanar::fan;
    options.divisions = cage.divisions == 0 ? 1 : cage.divisions;
    return use(PolyhedralMesh<T>(vertices, faces, options));
}

/// Makes the polygon or the triangles of a cage.
template <class T, std::size_t D>
cageform_status simple_cage_of(const cageform_cage& cage,
                               std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>& made) {
    if (cage.kind != (D == 2 ? CAGEFORM_POLYGON : CAGEFORM_MESH)) return CAGEFORM_CAGE_KIND_NOT_SUPPORTED;
    if constexpr (D == 2) {
        return polygon_of(cage, made);
    } else {
        return with_mesh<T>(cage, [&]<class Mesh>(Mesh mesh) {
            if constexpr (!std::is_same_v<Mesh, TriangleMesh<T>>)
                return CAGEFORM_CAGE_KIND_NOT_SUPPORTED;
            else
                made = std::move(mesh);
            return CAGEFORM_OK;
        });
    }
}

/// Makes a cage with the cells inside it.
template <class T, std::size_t D>
cageform_status complex_of(const cageform_cage& cage, CellComplex<T, D>& made) {
    typename CellComplex<T, D>::Boundary boundary;
    std::vector<Vec<T, D>> vertices;
    cageform_status status = simple_cage_of<T, D>(cage, boundary);
    if (status == CAGEFORM_OK) status = copy_points(cage.vertices, vertices);
    if (status != CAGEFORM_OK) return status;
    if (cage.bones == nullptr && cage.bone_count > 0) return CAGEFORM_ARGUMENT_NULL;
    if (cage.walls == nullptr && cage.wall_index_count > 0) return CAGEFORM_ARGUMENT_NULL;
    if (cage.wall_index_count % D != 0) return CAGEFORM_COUNTS_DO_NOT_MATCH;
    InteriorCells<D> cells;
    for (std::size_t n = 0; n < cage.bone_count; ++n) {
        const cageform_bone& bone = cage.bones[n];
        if ((std::max)(bone.a, bone.b) >= vertices.size()) return CAGEFORM_INDEX_OUT_OF_BOUNDS;
        cells.bones.push_back({bone.a, bone.b, bone.radius});
    }
    cells.facets.resize(cage.wall_index_count / D);
    const std::uint32_t* corner = cage.walls;
    for (auto& facet : cells.facets) {
        for (std::uint32_t& vertex : facet) {
            vertex = *corner++;
            if (vertex >= vertices.size()) return CAGEFORM_INDEX_OUT_OF_BOUNDS;
        }
    }
    made = CellComplex<T, D>(std::move(boundary), vertices, std::move(cells));
    return CAGEFORM_OK;
}

template <class T, std::size_t D>
LatticeCoordinates<T, D> lattice_of(const cageform_cage& cage) {
    std::array<LatticeAxis, D> axes;
    Transform<T, D> box;
    for (std::size_t k = 0; k < D; ++k) {
        axes[k].points = cage.points[k] != 0 ? cage.points[k] : 4;
        axes[k].degree = cage.degree[k] != 0 ? cage.degree[k] : 3;
        box.translation[k] = static_cast<T>(cage.origin[k]);
        for (std::size_t n = 0; n < D; ++n) box.columns[k][n] = static_cast<T>(cage.axes[k][n]);
    }
    return LatticeCoordinates<T, D>(axes, box, static_cast<T>(cage.falloff));
}

inline HarmonicOptions harmonic_options(const cageform_coordinates_options& options) {
    HarmonicOptions own;
    if (options.accuracy != 0) own.accuracy = options.accuracy;
    if (options.memory_limit != 0) own.memory_limit = options.memory_limit;
    return own;
}

template <class T, std::size_t D>
cageform_status coordinates_of(const cageform_cage& cage, const cageform_coordinates_options& options,
                               AnyCoordinates<T, D>& made) {
    const auto keep = [&](auto coordinates) {
        made = std::move(coordinates);
        return cageform_status(CAGEFORM_OK);
    };
    if (options.type > CAGEFORM_SPLINES) return CAGEFORM_CHOICE_UNKNOWN;
    if (has_cells(cage)) {
        if (options.type != CAGEFORM_HARMONIC) return CAGEFORM_INTERIOR_CELLS_NOT_SUPPORTED;
        CellComplex<T, D> cells;
        const cageform_status status = complex_of(cage, cells);
        if (status != CAGEFORM_OK) return status;
        return keep(
            HarmonicCoordinates<T, D, CellComplex<T, D>>(std::move(cells), harmonic_options(options)));
    }
    if (options.type == CAGEFORM_SPLINES || cage.kind == CAGEFORM_LATTICE) {
        if (options.type != CAGEFORM_SPLINES || cage.kind != CAGEFORM_LATTICE)
            return CAGEFORM_CAGE_KIND_NOT_SUPPORTED;
        return keep(lattice_of<T, D>(cage));
    }
    if (options.type == CAGEFORM_SIBSON && cage.kind != CAGEFORM_CURVES) {
        std::vector<Vec<T, D>> sites;
        const cageform_status status = copy_points(cage.vertices, sites);
        if (status != CAGEFORM_OK) return status;
        return keep(SibsonCoordinates<T, D>(
            PointSet<T, D>(sites), {.degree = options.sibson_degree == 0 ? 1 : int(options.sibson_degree)}));
    }
    if constexpr (D == 2) {
        if (cage.kind == CAGEFORM_CURVES && options.type == CAGEFORM_GREEN) {
            CurvedPolygon<T> curves;
            const cageform_status status = curves_of(cage, curves);
            if (status != CAGEFORM_OK) return status;
            CurvedGreenOptions<T> own;
            if (options.disk[2] != 0)
                own.disk = {{static_cast<T>(options.disk[0]), static_cast<T>(options.disk[1])},
                            static_cast<T>(options.disk[2])};
            return keep(CurvedGreenCoordinates<T>(std::move(curves), own));
        }
        if (cage.kind != CAGEFORM_POLYGON) return CAGEFORM_CAGE_KIND_NOT_SUPPORTED;
        Polygon<T> polygon;
        const cageform_status status = polygon_of(cage, polygon);
        if (status != CAGEFORM_OK) return status;
        switch (options.type) {
        case CAGEFORM_MEAN_VALUE: return keep(MeanValueCoordinates<T, 2>(polygon));
        case CAGEFORM_HARMONIC: return keep(HarmonicCoordinates<T, 2>(polygon, harmonic_options(options)));
        case CAGEFORM_GREEN: return keep(GreenCoordinates<T, 2>(polygon));
        case CAGEFORM_WACHSPRESS: return keep(WachspressCoordinates<T>(polygon));
        case CAGEFORM_DISCRETE_HARMONIC: return keep(DiscreteHarmonicCoordinates<T>(polygon));
        default: return keep(BarycentricCoordinates<T, 2>(polygon));
        }
    } else {
        if (cage.kind != CAGEFORM_MESH || options.type >= CAGEFORM_WACHSPRESS)
            return CAGEFORM_CAGE_KIND_NOT_SUPPORTED;
        if (options.type == CAGEFORM_BARYCENTRIC) {
            std::vector<Vec<T, 3>> corners;
            const cageform_status status = copy_points(cage.vertices, corners);
            return status != CAGEFORM_OK ? status : keep(BarycentricCoordinates<T, 3>(corners));
        }
        return with_mesh<T>(cage, [&](const auto& mesh) {
            using Mesh = std::remove_cvref_t<decltype(mesh)>;
            switch (options.type) {
            case CAGEFORM_MEAN_VALUE: return keep(MeanValueCoordinates<T, 3, Mesh>(mesh));
            case CAGEFORM_GREEN: return keep(GreenCoordinates<T, 3, Mesh>(mesh));
            default: return keep(HarmonicCoordinates<T, 3, Mesh>(mesh, harmonic_options(options)));
            }
        });
    }
}

template <class T, std::size_t D>
cageform_status blend_of(std::span<const cageform_cage* const> cages,
                         const cageform_coordinates_options& options, AnyCoordinates<T, D>& made,
                         std::size_t& culprit) {
    using Cage = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>;
    const auto blend = [&](const auto& coordinates_of_one) {
        std::vector<decltype(coordinates_of_one(Cage{}))> components;
        for (const cageform_cage* given : cages) {
            culprit = components.size();
            cageform_cage own;
            Cage cage;
            if (given == nullptr) return cageform_status(CAGEFORM_ARGUMENT_NULL);
            cageform_status status = read_struct(given, own);
            if (status == CAGEFORM_OK && has_cells(own)) status = CAGEFORM_INTERIOR_CELLS_NOT_SUPPORTED;
            if (status == CAGEFORM_OK) status = simple_cage_of<T, D>(own, cage);
            if (status != CAGEFORM_OK) return status;
            components.push_back(coordinates_of_one(std::move(cage)));
        }
        BlendedCoordinates blended(std::move(components));
        culprit = blended.refused_component();
        made = std::move(blended);
        return cageform_status(CAGEFORM_OK);
    };
    switch (options.type) {
    case CAGEFORM_MEAN_VALUE:
        return blend([](Cage cage) { return MeanValueCoordinates<T, D>(std::move(cage)); });
    case CAGEFORM_HARMONIC:
        return blend(
            [&](Cage cage) { return HarmonicCoordinates<T, D>(std::move(cage), harmonic_options(options)); });
    default:
        return options.type > CAGEFORM_SPLINES ? CAGEFORM_CHOICE_UNKNOWN : CAGEFORM_CAGE_KIND_NOT_SUPPORTED;
    }
}

template <class T, std::size_t D>
cageform_status check_cage(const cageform_cage& cage, CageReport& report) {
    const auto keep = [&](CageReport its) {
        report = std::move(its);
        return cageform_status(CAGEFORM_OK);
    };
    const auto check_made = [&](const auto& made, cageform_status status) {
        return status != CAGEFORM_OK ? status : keep(check(made));
    };
    if (has_cells(cage)) {
        CellComplex<T, D> cells;
        const cageform_status status = complex_of(cage, cells);
        return check_made(cells, status);
    }
    if (cage.kind == CAGEFORM_LATTICE) return keep(lattice_of<T, D>(cage).cage_report());
    if (cage.kind == CAGEFORM_SITES) {
        std::vector<Vec<T, D>> sites;
        const cageform_status status = copy_points(cage.vertices, sites);
        return check_made(PointSet<T, D>(sites), status);
    }
    if constexpr (D == 3) {
        return with_mesh<T>(cage, [&](const auto& mesh) { return keep(check(mesh)); });
    } else if (cage.kind == CAGEFORM_CURVES) {
        CurvedPolygon<T> curves;
        const cageform_status status = curves_of(cage, curves);
        return check_made(curves, status);
    } else {
        Polygon<T> polygon;
        const cageform_status status = polygon_of(cage, polygon);
        return check_made(polygon, status);
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c
