// Makes PoseSamples: samples the interior of a cage, clusters the samples, and computes sums.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/pose_samples/sample_clusters.hpp>
#include <cageform/binding/pose_samples/sample_lattice.hpp>
#include <cageform/binding/pose_samples/sample_sums.hpp>
#include <cageform/binding/types/pose_sample_options.hpp>
#include <cageform/core/affine/affine_rows.hpp>
#include <cageform/core/detail/face_handles.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Coordinates with gradients; AnyCoordinates report them at run time.
template <class C>
concept SampledCoordinates = GradientCoordinates<C> || requires(const C& c) {
    { c.has_gradients() } -> std::same_as<bool>;
};

/// Whether weights are defined outside the cage.
template <class C>
bool has_weights_outside(const C& coordinates) noexcept {
    if constexpr (CageCoordinates<C>)
        return C::has_extension;
    else
        return coordinates.has_extension();
}

template <SampledCoordinates C>
class PoseSampler {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;

public:
    /// `given` are the samples; null for a lattice inside the cage.
    PoseSampler(const C& coordinates, const std::vector<Vec<T, D>>* given, const PoseSampleOptions& options,
                PoseSamplesReport& report)
        : coordinates_(coordinates)
        , given_(given)
        , options_(options)
        , report_(report)
        , handles_(handle_view(coordinates)) {}

    Status run(PoseSamples<T, D>& to, const Running& running) {
        Status status = begin(to, running.subtask(0, 0.3));
        if (status != Status::ok) return status;
        SampleClusters<T, D> clusters(sampled_.points, to.centre, to.size, to.cluster_count, running);
        if (!running.keep_going(0.4)) return Status::cancelled;
        cluster_of_ = std::move(clusters.cluster_of);
        report_.rotations = clusters.centres.size();
        SampleSums<T, D> sums(handles_.count, clusters.centres.size());
        if (status = add_samples(to, sums, running.subtask(0.4, 0.9)); status != Status::ok) return status;
        if (report_.spokes > 0) status = add_spokes(to, sums, clusters.centres, running.subtask(0.9, 1));
        if (status != Status::ok) return status;
        sums.write(to);
        to.points = std::move(sampled_.points);
        to.clusters = std::move(cluster_of_);
        to.centres = std::move(clusters.centres);
        return running.end(Status::ok);
    }

private:
    /// Sets the properties of the handles, and finds the samples.
    Status begin(PoseSamples<T, D>& to, const Running& running) {
        if (coordinates_.cage_report().status != Status::ok) return coordinates_.cage_report().status;
        if constexpr (!GradientCoordinates<C>) {
            if (!coordinates_.has_gradients()) return Status::gradients_not_supported;
        }
        if (!(options_.smoothing >= 0) || !is_finite(options_.smoothing) || !is_finite(options_.spokes))
            return Status::value_not_finite;
        const std::size_t count = handles_.count;
        if (count > to.most_handles) return Status::too_many_handles;
        to.rest_handles.assign(handles_.rest, handles_.rest + count);
        for (std::size_t i = 0; i < count; ++i)
            to.handle_kinds.push_back(handles_.is_point(i) ? HandleKind::point : HandleKind::vector);
        const auto box = bounds_of_points<double>(handles_);
        to.size = box.diagonal();
        if (count == 0 || !(to.size > 0)) return Status::samples_missing;
        to.centre = 0.5 * (box.lower + box.upper);
        report_.spokes = options_.spokes >= 0 ? options_.spokes : handles_.vector_count() > 0 ? 1e-2 : 1e-3;
        if (given_ != nullptr) {
            for (const auto& p : *given_) {
                if (is_finite(p)) sampled_.points.push_back(p);
            }
            report_.left_out = given_->size() - sampled_.points.size();
        } else {
            const std::size_t wanted =
                options_.samples != 0 ? options_.samples : (std::max)(std::size_t{4000}, 16 * count);
            const Status status = SampleLattice<C>(coordinates_, box).find(wanted, sampled_, running);
            if (status != Status::ok) return status;
        }
        if (sampled_.points.empty()) return Status::samples_missing;
        to.cluster_count = options_.rotations != 0
                               ? options_.rotations
                               : (std::min)(std::size_t{400}, (std::max)(std::size_t{200}, 2 * count));
        return Status::ok;
    }

    /// Binds the axes at samples in batches and adds them to the sums. Coordinates that would solve in
    /// each call get all samples at once.
    Status add_samples(const PoseSamples<T, D>& to, SampleSums<T, D>& sums, const Running& running) {
        const bool keeps = is_closed_form(coordinates_) || requires(C& c) { c.solve(Running{}); };
        const std::size_t count = sampled_.points.size(), batch = keeps ? 512 : count;
        constexpr std::uint32_t none = ~std::uint32_t{0};
        column_.assign(count, none);
        size_ = to.size;
        std::vector<Vec<T, D>> points;
        std::vector<std::uint32_t> numbers;
        std::size_t pair = 0;
        for (std::size_t first = 0; first < count; first += batch) {
            const std::size_t last = (std::min)(first + batch, count);
            numbers.clear();
            const auto add = [&](std::uint32_t s) {
                if (column_[s] != none) return;
                column_[s] = std::uint32_t(numbers.size());
                numbers.push_back(s);
            };
            for (std::size_t s = first; s < last; ++s) add(std::uint32_t(s));
            const std::size_t first_pair = pair;
            if (options_.smoothing > 0) {
                for (; pair < sampled_.neighbours.size() && sampled_.neighbours[pair][1] < last; ++pair)
                    add(sampled_.neighbours[pair][0]);
            }
            points.clear();
            for (const std::uint32_t s : numbers) points.push_back(sampled_.points[s]);
            if (const Status status = set_gradients(points, running); status != Status::ok) return status;
            add_batch(last - first, numbers, sums, running);
            add_pairs(first_pair, pair, sums, running);
            for (const std::uint32_t s : numbers) column_[s] = none;
            if (!running.keep_going(double(last) / double(count))) return Status::cancelled;
        }
        if (report_.samples == 0) return Status::samples_missing;
        sums.finish_samples(report_.samples);
        return Status::ok;
    }

    /// Computes the gradients at points, D columns per point, and which points have gradients.
    Status set_gradients(const std::vector<Vec<T, D>>& points, const Running& running) {
        auto [axes, report] = bind_jacobians(coordinates_, points, {}, {running.parallel, {}});
        report_.bind = std::move(report);
        if (report_.bind.status != Status::ok) return report_.bind.status;
        has_gradients_.assign(points.size(), true);
        const auto leave_out = [&](const std::vector<std::size_t>& list) {
            for (const std::size_t n : list) has_gradients_[n] = false;
        };
        leave_out(report_.bind.not_finite);
        leave_out(report_.bind.unreached);
        if (!has_weights_outside(coordinates_)) leave_out(report_.bind.outside);
        gradients_.resize(handles_.count * points.size() * D);
        for (std::size_t n = 0; n < points.size(); ++n) {
            for (std::size_t k = 0; k < D; ++k) {
                for (std::size_t i = 0; i < handles_.count; ++i)
                    gradients_[(n * D + k) * handles_.count + i] =
                        has_gradients_[n] ? size_ * double(axes[k].weight(n, i)) : 0;
            }
        }
        return Status::ok;
    }
    void add_batch(std::size_t count, const std::vector<std::uint32_t>& numbers, SampleSums<T, D>& sums,
                   const Running& running) {
        const std::size_t sample_size = D * handles_.count; // in numbers
        sums.add_products(std::span(gradients_).first(count * sample_size), running);
        for (std::size_t n = 0; n < count; ++n) {
            if (has_gradients_[n])
                sums.add_sample(std::span(gradients_).subspan(n * sample_size, sample_size),
                                cluster_of_[numbers[n]]);
            report_.samples += has_gradients_[n] ? 1 : 0;
            report_.left_out += has_gradients_[n] ? 0 : 1;
        }
    }
    /// Adds the differences of neighbours, weighted by the smoothness.
    void add_pairs(std::size_t first, std::size_t last, SampleSums<T, D>& sums, const Running& running) {
        if (first == last) return;
        const std::size_t sample_size = D * handles_.count;
        std::vector<double> differences((last - first) * sample_size);
        for (std::size_t n = first; n < last; ++n) {
            const auto [a, b] = sampled_.neighbours[n];
            if (!has_gradients_[column_[a]] || !has_gradients_[column_[b]]) continue;
            const auto apart = (1 / size_) * vec_cast<double>(sampled_.points[a] - sampled_.points[b]);
            const double factor = options_.smoothing / std::sqrt(dot(apart, apart));
            const double* const of_a = gradients_.data() + column_[a] * sample_size;
            const double* const of_b = gradients_.data() + column_[b] * sample_size;
            for (std::size_t i = 0; i < sample_size; ++i)
                differences[(n - first) * sample_size + i] = factor * (of_a[i] - of_b[i]);
        }
        sums.add_products(differences, running);
    }

    Status add_spokes(const PoseSamples<T, D>& to, SampleSums<T, D>& sums,
                      const std::vector<std::uint32_t>& centres, const Running& running) {
        std::vector<Vec<T, D>> places;
        places.reserve(centres.size());
        for (const std::uint32_t s : centres) places.push_back(sampled_.points[s]);
        auto [binding, bound] = bind(coordinates_, places, BindOptions{}, running);
        if (bound.status != Status::ok) return bound.status;
        std::size_t vectors = 0;
        for (std::size_t i = 0; i < handles_.count; ++i) {
            const bool is_point = handles_.is_point(i);
            const auto place = position_of(to, i, vectors);
            vectors += is_point ? 0 : 1;
            std::size_t nearest = 0;
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t c = 0; c < places.size(); ++c) {
                const auto away = vec_cast<double>(places[c]) - place;
                if (!(dot(away, away) < (1 - 1e-9) * least)) continue; // ignores differences by rounding
                least = dot(away, away);
                nearest = c;
            }
            auto direction = vec_cast<double>(handles_.rest[i]);
            if (is_point) direction = direction - vec_cast<double>(places[nearest]);
            const double length = std::sqrt(dot(direction, direction));
            if (!(length > 1e-6 * to.size)) continue; // the handle coincides with the sample
            std::vector<double> gradient(handles_.count);
            for (std::size_t h = 0; is_point && h < handles_.count; ++h)
                gradient[h] = -double(binding.weight(nearest, h));
            gradient[i] += 1;
            for (double& x : gradient) x *= to.size / length;
            sums.add_spoke(gradient, (1 / length) * direction, nearest,
                           report_.spokes / double(handles_.count));
        }
        return Status::ok;
    }
    /// Returns the position of a handle: for a vector, the centre of its face, or of the cage if it has none.
    Vec<double, D> position_of(const PoseSamples<T, D>& to, std::size_t i, std::size_t vector) const {
        if (handles_.is_point(i)) return vec_cast<double>(handles_.rest[i]);
        if (handles_.faces == nullptr) return to.centre;
        Vec<double, D> sum{};
        for (const std::uint32_t corner : handles_.faces[vector])
            sum = sum + vec_cast<double>(corner_of_face(handles_, corner,
                                                        [&](std::uint32_t h) { return handles_.rest[h]; }));
        return (1 / double(D)) * sum;
    }

    const C& coordinates_;
    const std::vector<Vec<T, D>>* given_;
    const PoseSampleOptions& options_;
    PoseSamplesReport& report_;
    HandleView<T, D> handles_;
    SamplePoints<T, D> sampled_;
    std::vector<std::uint32_t> cluster_of_;
    std::vector<std::uint32_t> column_; ///< #samples: the index of a sample in the batch, or none
    double size_ = 0;                   ///< the cage's size
    /// D columns of #handles numbers for each point of a batch, in units of the cage's size.
    std::vector<double> gradients_;
    std::vector<bool> has_gradients_; ///< the points of a batch that have gradients
};

/// Makes samples under guard_memory. A solver solves only once.
template <SampledCoordinates C>
Result<PoseSamples<typename C::scalar, C::dimension>, PoseSamplesReport>
make_pose_samples(const C& coordinates, const std::vector<Vec<typename C::scalar, C::dimension>>* given,
                  const PoseSampleOptions& options, const Running& running) {
    Result<PoseSamples<typename C::scalar, C::dimension>, PoseSamplesReport> result;
    run_into(result.report, [&] {
        const auto run = [&](const C& solved, const Running& rest) {
            return PoseSampler<C>(solved, given, options, result.report).run(result.value, rest);
        };
        if constexpr (requires(C& c) { c.solve(running); }) {
            C solved = coordinates; // keeps its functions for all batches
            result.report.bind.status = solved.solve(running.subtask(0, 0.5)).status;
            if (result.report.bind.status != Status::ok) return result.report.bind.status;
            return run(solved, running.subtask(0.5, 1));
        } else {
            return run(coordinates, running);
        }
    });
    if (result.report.status != Status::ok) result.value = {};
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
