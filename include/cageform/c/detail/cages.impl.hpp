// Converts the cages of the C interface. cages.hpp includes this file, unless the program links
// cageform::compiled.
#pragma once

#include <cageform/binding/make_coordinates.hpp>
#include <cageform/c/detail/cages.hpp>

namespace cageform::inline CAGEFORM_ABI::detail::c {

/// Copies an array; null gives an empty one.
inline cageform_status copy_numbers(const std::uint32_t* numbers, std::size_t count,
                                    std::vector<std::size_t>& copied) {
    if (numbers == nullptr && count > 0) return CAGEFORM_ARGUMENT_NULL;
    if (numbers != nullptr) copied.assign(numbers, numbers + count);
    return CAGEFORM_OK;
}
/// Whether `sizes` sum to `count`. The sum does not overflow, since sizes have 32 bits.
inline bool add_up(const std::vector<std::size_t>& sizes, std::size_t count) noexcept {
    std::size_t sum = 0;
    for (const std::size_t size : sizes) {
        sum += size;
        if (sum > count) return false;
    }
    return sum == count;
}

/// Copies the vertices of the boundary, which precede those of cells.
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
        if (const double* knots = cage.knots[k]) axes[k].knots.assign(knots, knots + cage.knot_counts[k]);
        box.translation[k] = static_cast<T>(cage.origin[k]);
        for (std::size_t n = 0; n < D; ++n) box.columns[k][n] = static_cast<T>(cage.axes[k][n]);
    }
    return LatticeCoordinates<T, D>(axes, box, static_cast<T>(cage.falloff));
}

inline cageform_status type_of(const cageform_coordinates_options& options, CoordinateType& type) noexcept {
    switch (options.type) {
#define CAGEFORM_DETAIL_TYPE(name, NAME, ...)                                                                \
    case CAGEFORM_##NAME: type = CoordinateType::name; return CAGEFORM_OK;
        CAGEFORM_COORDINATE_TYPES(CAGEFORM_DETAIL_TYPE)
#undef CAGEFORM_DETAIL_TYPE
    default: return CAGEFORM_CHOICE_UNKNOWN;
    }
}

template <class T>
CoordinateOptions<T> options_of(const cageform_coordinates_options& options) {
    CoordinateOptions<T> own;
    if (options.accuracy != 0) own.harmonic.accuracy = options.accuracy;
    own.harmonic.locality = options.locality;
    if (options.memory_limit != 0) own.harmonic.memory_limit = options.memory_limit;
    if (options.sibson_degree != 0) own.sibson.degree = int(options.sibson_degree);
    if (options.disk[2] != 0)
        own.curved_green.disk = {{static_cast<T>(options.disk[0]), static_cast<T>(options.disk[1])},
                                 static_cast<T>(options.disk[2])};
    return own;
}

/// Calls use(cage) with the cage as the library's class for its kind.
///
///   kind   the kind of the cage, or CAGEFORM_SITES for only its vertices
template <class T, std::size_t D, class Use>
cageform_status with_cage(const cageform_cage& cage, std::uint32_t kind, const Use& use) {
    const auto use_made = [&](cageform_status status, const auto& made) {
        return status == CAGEFORM_OK ? use(made) : status;
    };
    if (has_cells(cage)) {
        CellComplex<T, D> cells;
        return use_made(complex_of(cage, cells), cells);
    }
    if (kind == CAGEFORM_LATTICE) return use(lattice_of<T, D>(cage));
    if (kind == CAGEFORM_SITES) {
        std::vector<Vec<T, D>> sites;
        const cageform_status status = copy_points(cage.vertices, sites);
        return use_made(status, PointSet<T, D>(sites));
    }
    if constexpr (D == 3) {
        return with_mesh<T>(cage, use);
    } else if (kind == CAGEFORM_CURVES) {
        CurvedPolygon<T> curves;
        return use_made(curves_of(cage, curves), curves);
    } else {
        Polygon<T> polygon;
        return use_made(polygon_of(cage, polygon), polygon);
    }
}

template <class T, std::size_t D>
cageform_status coordinates_of(const cageform_cage& cage, const cageform_coordinates_options& options,
                               AnyCoordinates<T, D>& made) {
    CoordinateType type{};
    if (const cageform_status status = type_of(options, type); status != CAGEFORM_OK) return status;
    if (type == CoordinateType::green && cage.kind == CAGEFORM_CURVES) type = CoordinateType::curved_green;
    const std::uint32_t cages = facts_of(type).cages;
    if (has_cells(cage) && (cages & cage_kinds::cells) == 0) return CAGEFORM_INTERIOR_CELLS_NOT_SUPPORTED;
    // The sites of a polygon or a mesh are its vertices.
    const bool by_sites =
        cages == cage_kinds::sites && (cage.kind == CAGEFORM_POLYGON || cage.kind == CAGEFORM_MESH);
    return with_cage<T, D>(cage, by_sites ? std::uint32_t(CAGEFORM_SITES) : cage.kind, [&](const auto& its) {
        if ((cages & kinds_of<std::remove_cvref_t<decltype(its)>>) == 0)
            return cageform_status(CAGEFORM_CAGE_KIND_NOT_SUPPORTED);
        made = make_coordinates(type, its, options_of<T>(options));
        return cageform_status(CAGEFORM_OK);
    });
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
    CoordinateType type{};
    if (const cageform_status status = type_of(options, type); status != CAGEFORM_OK) return status;
    if (type == CoordinateType::mean_value)
        return blend([](Cage cage) { return MeanValueCoordinates<T, D>(std::move(cage)); });
    if (type != CoordinateType::harmonic) return CAGEFORM_CAGE_KIND_NOT_SUPPORTED;
    return blend([&](Cage cage) {
        return HarmonicCoordinates<T, D>(std::move(cage), options_of<T>(options).harmonic);
    });
}

template <class T, std::size_t D>
cageform_status check_cage(const cageform_cage& cage, CageReport& report) {
    const auto keep = [&](CageReport its) {
        report = std::move(its);
        return cageform_status(CAGEFORM_OK);
    };
    return with_cage<T, D>(cage, cage.kind, [&](const auto& its) {
        if constexpr (requires { its.cage_report(); })
            return keep(its.cage_report()); // a lattice
        else
            return keep(check(its));
    });
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c
