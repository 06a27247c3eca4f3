#include "files/welded_mesh.hpp"

#include <map>

namespace cageform_support {

WeldedMesh welded_mesh(const MeshFile& figure) {
    WeldedMesh mesh;
    std::map<std::array<double, 3>, std::uint32_t> known;
    const std::vector<Point3> joined = joined_places(figure);
    for (std::uint32_t v = 0; v < joined.size(); ++v) {
        const Point3& p = joined[v];
        const auto [at, is_new] = known.insert({{p[0], p[1], p[2]}, std::uint32_t(mesh.places.size())});
        mesh.place_of.push_back(at->second);
        if (!is_new) continue;
        mesh.places.push_back(p);
        mesh.first.push_back(v);
    }
    for (const auto& [a, b, c] : figure.triangles) {
        const std::array<std::uint32_t, 3> t{mesh.place_of[a], mesh.place_of[b], mesh.place_of[c]};
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles.push_back(t);
    }
    return mesh;
}

WeldedMesh welded_surface(const MeshFile& figure) {
    WeldedMesh all = welded_mesh(figure), used;
    std::vector<std::uint32_t> kept(all.places.size(), WeldedMesh::no_place);
    for (const auto& triangle : all.triangles) {
        for (const std::uint32_t place : triangle) kept[place] = 0;
    }
    for (std::size_t n = 0; n < kept.size(); ++n) {
        if (kept[n] == WeldedMesh::no_place) continue;
        kept[n] = std::uint32_t(used.places.size());
        used.places.push_back(all.places[n]);
        used.first.push_back(all.first[n]);
    }
    for (const std::uint32_t place : all.place_of) used.place_of.push_back(kept[place]);
    for (const auto& [a, b, c] : all.triangles) used.triangles.push_back({kept[a], kept[b], kept[c]});
    return used;
}

} // namespace cageform_support
