// Reference values of high precision, kept in tests/data/oracle (what the keys mean stands in its README).
#pragma once

#include <cageform/cage/polygon.hpp>

#include <nlohmann/json.hpp>

#include <fstream>
#include <string>
#include <vector>

namespace cageform_tests {

struct Oracle {
    std::vector<cageform::Vec<double, 2>> vertices;
    std::vector<std::size_t> loop_sizes;
    std::vector<cageform::Vec<double, 2>> points;
    std::vector<std::string> tags;
    std::vector<std::vector<double>> coordinates; ///< [point][vertex]
    double error_bound = 0;

    template <class T>
    cageform::Polygon<T> cage() const {
        return {vertices, loop_sizes};
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
    oracle.points = points(json["points"]);
    oracle.tags = json["point_tags"].get<std::vector<std::string>>();
    oracle.coordinates = json["coordinates"].get<std::vector<std::vector<double>>>();
    oracle.error_bound = json["error_bound"].get<double>();
    return oracle;
}

} // namespace cageform_tests
