#include "cli/followers.hpp"

#include "cli/auto_cage.hpp"
#include "cli/wrap_report.hpp"
#include "files/obj_parts.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <algorithm>
#include <cmath>

namespace cageform_support {

namespace {

cageform::SurfaceMesh surface_of(const WeldedMesh& mesh) {
    return {mesh.places, mesh.triangles};
}

} // namespace

WrapSurfaces::WrapSurfaces(const WrapFigures& figures, double its_height)
    : target_mesh(surface_of(figures.target_surface))
    , source(figures.source_surface.places, figures.source_surface.triangles)
    , target(figures.target_surface.places, figures.target_surface.triangles)
    , height(its_height) {}

Follower Follower::read(const std::string& word, bool is_strict) {
    Follower made;
    fail_if(parse_file_pair(word, made.name_, made.out_));
    if (is_mesh_path(made.name_)) {
        made.mesh_ = load_mesh_figure(made.name_, is_strict);
        fail_if(fault_of_extension(made.mesh_, made.out_, "--follow"));
    } else if (lowercase_extension(made.name_) == ".csv") {
        made.table_ = value_or_fail(load_point_table(made.name_));
        if (lowercase_extension(made.out_) != ".csv")
            throw Failure("--follow: " + made.out_ + ": points of " + made.name_ + " are written as .csv");
    } else {
        throw Failure("--follow: " + made.name_ + ": a follower is a mesh or a CSV file of points");
    }
    return made;
}

void Follower::move(const WrapMap& map) {
    moved_.resize(rest().size());
    if (!mesh_.normals.empty() || !mesh_.guides.empty()) jacobians_.resize(rest().size());
    map.move(rest(), moved_, jacobians_, name_);
    guides_.resize(mesh_.guides.size());
    map.move(mesh_.guides, guides_, {}, name_);
}

void Follower::push_out(const WrapSurfaces& surfaces, std::optional<double> distance) {
    if (!is_mesh()) return;
    height_ = surfaces.height;
    const WeldedMesh joined = welded_mesh(mesh_);
    std::vector<Point3> places;
    for (const std::uint32_t vertex : joined.first) places.push_back(moved_[vertex]);
    const auto was_outside = surfaces.source.are_outside(joined.places);
    if (distance) {
        const auto before = places;
        pushed_ = cageform::push_out(surfaces.target_mesh, {places, joined.triangles}, was_outside, places,
                                     *distance * height_);
        if (pushed_->status != cageform::Status::ok)
            throw Failure(name_ + ": --push-out: " + cageform::to_string(pushed_->status));
        for (std::size_t i = 0; i < moved_.size(); ++i) {
            const std::uint32_t n = joined.place_of[i];
            moved_[i] = moved_[i] + (places[n] - before[n]);
        }
    }
    for (std::size_t n = 0; n < places.size(); ++n) {
        if (was_outside[n] == 0) continue;
        ++checked_;
        const auto at = surfaces.target.find(places[n]);
        const Point3 off = places[n] - at.place;
        if (dot(off, at.normal) >= 0 || surfaces.target.is_on_rim(at.face)) continue;
        ++inside_;
        depth_ = std::max(depth_, std::sqrt(dot(off, off)) / height_);
    }
}

std::vector<std::string> Follower::save(OutputFiles& outputs) const {
    if (!is_mesh()) {
        outputs.add(out_).write(to_text(table_, moved_));
        return {};
    }
    auto notes = value_or_fail(save_mesh(mesh_, {moved_, jacobians_, guides_}, out_, outputs));
    notes.push_back(describe_materials(mesh_, out_));
    return notes;
}

std::string Follower::describe() const {
    std::string text = out_ + ": " + std::to_string(moved_.size()) + (is_mesh() ? " vertices" : " points");
    if (checked_ == 0) return text;
    if (pushed_ && pushed_->moved > 0)
        text += "; --push-out moved " + std::to_string(pushed_->moved) + " by at most " +
                percent_of(pushed_->largest / height_) + " of the target's height, " +
                percent_of(pushed_->mean / height_) + " in the mean; before, " +
                std::to_string(pushed_->inside) + " were inside the target, now";
    else
        text += ';';
    text += ' ' + std::to_string(inside_) + " of " + std::to_string(checked_) + " are inside" +
            (pushed_ && pushed_->moved > 0 ? "" : " the target");
    return inside_ == 0 ? text : text + ", at most " + percent_of(depth_) + " of its height deep";
}

std::string Follower::warning() const {
    if (!pushed_ || pushed_->turned == 0) return {};
    return out_ + ": --push-out would turn " + std::to_string(pushed_->turned) + " faces over; " +
           std::to_string(pushed_->held) + " vertices went only a part of their way";
}

MorphFile MorphFile::read(const std::string& word, const MeshFile& source, bool is_strict) {
    MorphFile made;
    std::string in;
    fail_if(parse_file_pair(word, in, made.out_));
    made.mesh_ = load_mesh_figure(in, is_strict);
    fail_if(fault_of_frame(source, made.mesh_));
    fail_if(fault_of_extension(made.mesh_, made.out_, "--morph"));
    return made;
}

std::vector<std::string> MorphFile::save(const MeshFile& source, const MovedVertices& wrapped,
                                         OutputFiles& outputs) const {
    std::vector<Point3> places(wrapped.places.begin(), wrapped.places.end());
    for (std::size_t i = 0; i < places.size(); ++i) {
        const Point3 step = mesh_.vertices[i] - source.vertices[i];
        for (std::size_t k = 0; k < 3; ++k) places[i] = places[i] + step[k] * wrapped.jacobians[i][k];
    }
    return value_or_fail(save_mesh(mesh_, {places, wrapped.jacobians}, out_, outputs));
}

} // namespace cageform_support
