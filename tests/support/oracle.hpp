// Reference values of high precision, kept in tests/data/oracle (what the keys mean stands in its README).
#pragma once

#include <cageform/cage/cell_complex.hpp>

#include <nlohmann/json.hpp>

#include <fstream>
#include <string>
#include <vector>

namespace cageform_tests {

struct Oracle {
    std::vector<cageform::Vec<double, 2>> vertices;
    std::vector<std::size_t> loop_sizes;
    std::vector<std::size_t> chain; ///< vertices, the last of which belong to no loop
    std::vector<cageform::Vec<double, 2>> points;
    std::vector<std::string> tags;
    std::vector<std::vector<double>> coordinates; ///< [point][vertex]
    double error_bound = 0;

    template <class T>
    cageform::Polygon<T> cage() const {
        return {vertices, loop_sizes};
    }
    template <class T>
    cageform::CellComplex<T, 2> complex() const {
        std::size_t outer = 0;
        for (const std::size_t size : loop_sizes) outer += size;
        const std::vector<cageform::Vec<double, 2>> outline(vertices.begin(),
                                                            vertices.begin() + std::ptrdiff_t(outer));
        cageform::CellComplex<T, 2> all(cageform::Polygon<T>(outline, loop_sizes));
        std::vector<cageform::Vec<double, 2>> places;
        for (const std::size_t i : chain) places.push_back(vertices[i]);
        all.add_chain(places);
        return all;
    }
};

inline nlohmann::json read_json(const std::string& name) {
    std::ifstream file(std::string(CAGEFORM_TEST_DATA) + "/oracle/" + name + ".json");
    return nlohmann::json::parse(file);
}

/// A two-dimensional case by its file name without ".json".
inline Oracle read_oracle(const std::string& name) {
    const auto json = read_json(name);
    Oracle oracle;
    const auto points = [](const nlohmann::json& list) {
        std::vector<cageform::Vec<double, 2>> result;
        for (const auto& p : list) result.push_back({p[0].get<double>(), p[1].get<double>()});
        return result;
    };
    oracle.vertices = points(json["cage"]["vertices"]);
    for (const auto& loop : json["cage"]["loops"]) oracle.loop_sizes.push_back(loop.size());
    if (json["cage"].contains("interior_chain"))
        oracle.chain = json["cage"]["interior_chain"].get<std::vector<std::size_t>>();
    oracle.points = points(json["points"]);
    oracle.tags = json["point_tags"].get<std::vector<std::string>>();
    oracle.coordinates = json["coordinates"].get<std::vector<std::vector<double>>>();
    oracle.error_bound = json["error_bound"].get<double>();
    return oracle;
}

} // namespace cageform_tests
