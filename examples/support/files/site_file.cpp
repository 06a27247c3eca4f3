#include "files/site_file.hpp"

#include "files/bind_report.hpp"
#include "files/mesh_file.hpp"
#include "svg/document.hpp"

#include <cageform/cage/control_points.hpp>

#include <bit>

namespace cageform_support {

namespace detail {

template <std::size_t D>
Expected<SiteFile<D>> read_site_csv(const std::string& path) {
    SiteFile<D> sites{path, {}, {}};
    PointReader<D> reader(path);
    for (std::vector<std::array<double, D>> next; reader.read(next, 1);) {
        sites.points.push_back(std::bit_cast<typename SiteFile<D>::Point>(next.front()));
        sites.places.push_back("line " + std::to_string(reader.line()));
    }
    if (!reader.error().empty()) return FileError{reader.error()};
    return sites;
}

Expected<SiteFile<2>> read_site_circles(const std::string& path) {
    const auto document = load_svg(path);
    if (!document) return document.error();
    auto all = shapes(*document);
    if (!all) return all.error();
    SiteFile<2> sites{path, {}, {}};
    for (SvgShape& shape : *all) {
        if (!shape.is_circle) continue;
        if (shape.path.empty())
            return FileError{path + ": " + shape.label + ": has no radius above 0, so it marks no point"};
        const Subpath& outline = shape.path.front(); // four arcs, or fewer if tiny
        const Point2 &a = outline.start, &b = outline.segments.size() == 4 ? outline.segments[1].p3 : a;
        sites.points.push_back({a.x + (b.x - a.x) / 2, a.y + (b.y - a.y) / 2});
        sites.places.push_back(std::move(shape.label));
    }
    if (sites.points.empty()) return FileError{path + ": holds no circles; their centres are the points"};
    return sites;
}

template Expected<SiteFile<2>> read_site_csv(const std::string&);
template Expected<SiteFile<3>> read_site_csv(const std::string&);

} // namespace detail

Expected<std::size_t> site_dimension(const std::string& path) {
    if (!path.ends_with(".csv")) return std::size_t(is_mesh_path(path) ? 3 : 2);
    const auto file = read_text(path);
    if (!file) return file.error();
    detail::RowFilter rows;
    std::string_view text = *file, line;
    while (take_line(text, line)) {
        if (rows.take(line)) return std::size_t(detail::cells_of(line).size() == 3 ? 3 : 2);
    }
    return FileError{path + ": holds no points"};
}

Expected<std::vector<double>> load_site_weights(const std::string& path, std::size_t count) {
    const auto file = read_text(path);
    if (!file) return file.error();
    std::vector<double> weights;
    detail::RowFilter rows;
    std::string_view text = *file, line;
    for (std::size_t number = 1; take_line(text, line); ++number) {
        if (!rows.take(line)) continue;
        const auto cells = detail::cells_of(line);
        double weight = 0;
        std::string why = cells.size() > 1 ? "a line has one weight" : detail::parse_number(cells[0], weight);
        if (why.empty() && !(std::isfinite(weight) && weight > 0))
            why = "a weight has to be a number above 0";
        if (!why.empty()) return detail::row_fault(path, number, line, why);
        weights.push_back(weight);
    }
    if (weights.size() == count) return weights;
    return FileError{path + ": holds " + std::to_string(weights.size()) + " weights where there are " +
                     std::to_string(count) + " points"};
}

template <std::size_t D>
std::string surround_sites(double margin, const std::vector<typename SiteFile<D>::Point>& figure,
                           SiteFile<D>& sites, SiteFile<D>& pose) {
    using Point = typename SiteFile<D>::Point;
    std::vector<Point> inside = figure;
    inside.insert(inside.end(), sites.points.begin(), sites.points.end());
    const auto around = cageform::surround(inside, {.margin = margin});
    if (!around)
        return sites.name + ": there is no box around the points: " + cageform::to_string(around.status());
    for (std::size_t i = 0; i < around.value.size(); ++i) {
        std::array<double, D> corner{};
        for (std::size_t k = 0; k < D; ++k) corner[k] = around.value[i][k];
        const auto site = std::bit_cast<Point>(corner);
        for (SiteFile<D>* file : {&sites, &pose}) {
            file->points.push_back(site);
            file->places.push_back("corner " + std::to_string(i + 1) + " of --surround");
        }
    }
    return {};
}

template <std::size_t D>
std::string single_precision_fault(const SiteFile<D>& sites) {
    for (std::size_t i = 0; i < sites.points.size(); ++i) {
        const auto p = cageform::to_vec<double>(sites.points[i]);
        for (std::size_t k = 0; k < D; ++k) {
            const std::string why = std::isfinite(p[k]) ? detail::single_precision_fault(p[k]) : "";
            if (!why.empty()) return sites.name + ": " + sites.places[i] + ": " + why;
        }
    }
    return {};
}

template <std::size_t D>
std::string describe_site_faults(const SiteFile<D>& sites, const cageform::BindReport& report) {
    if (report.status == cageform::Status::too_few_vertices) {
        return sites.name + ": holds too few points, " + std::to_string(sites.points.size()) + ": " +
               (D == 2 ? "in the plane three are needed" : "in space four are needed");
    }
    std::string text = sites.name + ": " + cageform::to_string(report.status);
    std::size_t listed = 0;
    for (const auto& fault : report.cage.faults) {
        if (listed == most_listed) break;
        const int numbers = numbers_of(fault.kind);
        if (numbers == 0) continue; // the status is sufficient
        ++listed;
        text += "\n  " + sites.places[fault.a];
        if (numbers > 1) text += " and " + sites.places[fault.b];
    }
    if (listed > 0 && report.cage.fault_count > listed)
        text += "\n  and " + std::to_string(report.cage.fault_count - listed) + " more";
    return text;
}

template std::string surround_sites<2>(double, const std::vector<Point2>&, SiteFile<2>&, SiteFile<2>&);
template std::string surround_sites<3>(double, const std::vector<Point3>&, SiteFile<3>&, SiteFile<3>&);
template std::string single_precision_fault(const SiteFile<2>&);
template std::string single_precision_fault(const SiteFile<3>&);
template std::string describe_site_faults(const SiteFile<2>&, const cageform::BindReport&);
template std::string describe_site_faults(const SiteFile<3>&, const cageform::BindReport&);

} // namespace cageform_support
