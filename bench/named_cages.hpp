// Named 3D cages, and command lines of programs that measure them.
#pragma once

#include "../tests/support/fingers.hpp"
#include "workloads.hpp"

#include <cageform/enclose/make_cage_3d.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>

namespace cageform_bench {

struct NamedCage {
    std::string name;
    cageform::TriangleMesh<double> mesh;
};

/// A prism over a triangulated polygon.
inline cageform::TriangleMesh<double> prism(const std::vector<std::array<double, 2>>& loop,
                                            const std::vector<std::array<int, 3>>& floor, double height) {
    std::vector<cageform::Vec<double, 3>> vertices;
    std::vector<std::array<int, 3>> faces;
    const int n = int(loop.size());
    for (const double z : {0.0, height}) {
        for (const auto& [x, y] : loop) vertices.push_back(cageform_tests::turned_about_123({x, y, z}, 1));
    }
    for (const auto& [a, b, c] : floor) {
        faces.push_back({a, c, b});
        faces.push_back({n + a, n + b, n + c});
    }
    for (int k = 0; k < n; ++k) {
        const int l = (k + 1) % n;
        faces.push_back({k, l, n + l});
        faces.push_back({k, n + l, n + k});
    }
    return {vertices, faces};
}

inline std::vector<NamedCage> named_cages() {
    std::vector<NamedCage> list;
    list.push_back({"cube", prism({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{0, 1, 2}, {0, 2, 3}}, 1)});
    list.push_back({"L", prism({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
                               {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}}, 1)});
    list.push_back({"U", prism({{0, 0}, {3, 0}, {3, 2}, {2, 2}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
                               {{0, 1, 4}, {0, 4, 5}, {1, 2, 4}, {2, 3, 4}, {0, 5, 7}, {5, 6, 7}}, 1)});
    list.push_back({"bumpy112", bumpy112<double>()});
    const auto fingers = cageform_tests::Fingers(CAGEFORM_BENCH_FINGERS).cage();
    for (const std::size_t vertices : {60u, 120u, 300u}) {
        cageform::MakeCageOptions options;
        options.vertices = vertices;
        list.push_back({"made" + std::to_string(vertices),
                        make_cage(fingers.vertices(), fingers.faces(), options).value});
    }
    list.push_back({"fingers", fingers});
    return list;
}

/// Words of a command line. Reads `--cage NAME` and `--obj FILE`; the program reads other words. Errors end
/// the program with a message.
class CommandLine {
public:
    CommandLine(const char* program, int argc, char** argv)
        : program_(program)
        , words_(argv + 1, argv + argc) {}

    /// Advances to the next word for the program.
    bool next() {
        while (at_ < words_.size()) {
            word_ = words_[at_++];
            if (word_ == "--cage")
                only_ = value();
            else if (word_ == "--obj")
                read_cage(value());
            else
                return true;
        }
        return false;
    }
    const std::string& word() const { return word_; }
    /// Reads the value of an option.
    const std::string& value() {
        if (at_ == words_.size()) refuse(word_ + " needs a value");
        return words_[at_++];
    }
    ObjMesh mesh() { return read_mesh(value()); }
    /// Reads a positive value of an option; integer for counts.
    template <class T>
    T number() {
        return number<T>(word_, value());
    }
    double accuracy() const {
        if (word_.starts_with("--")) refuse("unknown option " + word_);
        const auto accuracy = number<double>("accuracy", word_);
        if (accuracy < 1e-5 || accuracy > 0.1) refuse("accuracy " + word_ + " is not between 1e-5 and 0.1");
        return accuracy;
    }

    /// Returns the cages of the files or, without files, the named cages; only the selected one after --cage.
    std::vector<NamedCage> cages() const {
        auto list = files_.empty() ? named_cages() : files_;
        std::erase_if(list, [&](const NamedCage& cage) { return !only_.empty() && only_ != cage.name; });
        if (list.empty()) refuse("unknown cage " + only_);
        return list;
    }
    [[noreturn]] void refuse(const std::string& why) const {
        std::fprintf(stderr, "%s: %s\n", program_, why.c_str());
        std::exit(2);
    }

private:
    template <class T>
    T number(const std::string& what, const std::string& text) const {
        T number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error == std::errc{} && end == text.data() + text.size() && number > 0 &&
            number <= (std::numeric_limits<T>::max)())
            return number;
        refuse(what + " " + text + " is not a positive " +
               (std::is_integral_v<T> ? "whole number" : "number"));
    }
    ObjMesh read_mesh(const std::string& path) const {
        auto mesh = read_obj(path.c_str());
        if (mesh.vertices.empty()) refuse(path + ": has no vertex, or cannot be read");
        return mesh;
    }
    void read_cage(const std::string& path) {
        const auto obj = read_mesh(path);
        files_.push_back({std::filesystem::path(path).stem().string(), {obj.vertices, obj.faces}});
        const auto report = check(files_.back().mesh);
        if (report.status != cageform::Status::ok) refuse(path + ": " + to_string(report.status));
    }

    const char* program_;
    std::vector<std::string> words_;
    std::size_t at_ = 0;
    std::string word_, only_;
    std::vector<NamedCage> files_;
};

/// Sorted errors of points. `at(share)` is the quantile.
class Errors {
public:
    explicit Errors(std::vector<double> errors)
        : sorted_(std::move(errors)) {
        std::sort(sorted_.begin(), sorted_.end());
    }
    double at(double share) const { return sorted_[std::size_t(share * double(sorted_.size() - 1))]; }
    double share_beyond(double limit) const {
        const auto beyond = sorted_.end() - std::upper_bound(sorted_.begin(), sorted_.end(), limit);
        return double(beyond) / double(sorted_.size());
    }

private:
    std::vector<double> sorted_;
};

inline double degrees_between(const cageform::Vec<double, 3>& a, const cageform::Vec<double, 3>& b) {
    return 57.295779513 * std::atan2(cageform::detail::length(cross(a, b)), dot(a, b));
}

} // namespace cageform_bench
