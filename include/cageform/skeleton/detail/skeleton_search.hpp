// Looks for the fewest bones that keep every vertex within a distance.
#pragma once

#include <cageform/skeleton/detail/skeleton_fitter.hpp>

#include <limits>
#include <optional>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Short fits grow until one is near enough. It then loses bones as long as it stays so and the work lasts,
/// which is two and a half times that of a fit by number.
class SkeletonSearch {
public:
    struct Trial {
        std::size_t bones;
        bool holds;
    };

    SkeletonSearch(const Motion& motion, const SkeletonOptions& options, const Running& running)
        : options_(options)
        , running_(running)
        , moves_((std::max)(std::size_t{1}, options.moves / 4))
        , fitter_(motion, options, running) {}

    /// The fit of the fewest bones that holds; where none does, the nearest one.
    const BoneFit& best() const noexcept { return *best_; }
    /// The numbers that were tried, in this order.
    const std::vector<Trial>& trials() const noexcept { return trials_; }

    /// Tries 1 to `most` bones; holds(fit) says whether a fit is within the distance as it will be stored.
    template <class Holds>
    Status run(std::size_t most, const Holds& holds) {
        if (!start(1) || !polish(holds)) return Status::cancelled;
        if (found_ || most == 1) return Status::ok;
        std::size_t low = 1, high = (std::min)(most, std::size_t{4});
        if (!start(high) || !polish(holds)) return Status::cancelled;
        while (!found_) {
            if (high == most) return Status::ok;
            low = high;
            const double factor = std::pow(largest_ / options_.max_distance, 0.7);
            const double next = double(low) * (std::fmin)((std::fmax)(factor, 1.1), 2.0);
            high = (std::min)((std::max)(low + 1, std::size_t(next)), most);
            // A large step begins with clusters again, which spread many bones better.
            if (double(high) >= 1.3 * double(low) && !start(high)) return Status::cancelled;
            if (!change(high) || !polish(holds)) return Status::cancelled;
        }
        return shrink(low, holds) && smooth(holds) ? Status::ok : Status::cancelled;
    }

private:
    // The steps below return false where they are cancelled.

    /// Takes bones off the fit that was found. One that does not hold goes on once; then fewer are taken off.
    template <class Holds>
    bool shrink(std::size_t low, const Holds& holds) {
        std::size_t high = best_->bones();
        std::size_t step = high > low ? (std::max)(std::size_t{1}, (high - low) / 2) : 1;
        bool again = true;
        while (high > step + 1 && is_affordable(high - step)) {
            if (!change(high - step) || !polish(holds)) return false;
            if (found_) {
                high = best_->bones();
                step = (std::max)(std::size_t{1}, high / 16);
                again = true;
            } else if (again) {
                again = false;
            } else if (step == 1) {
                break;
            } else {
                step /= 2;
                fitter_.restore(*best_);
                again = true;
            }
        }
        return true;
    }
    /// Some rounds as fits by number have them, for the mean of the distances.
    template <class Holds>
    bool smooth(const Holds& holds) {
        fitter_.restore(*best_);
        for (std::size_t n = 0; n < options_.rounds / 2; ++n) {
            if (!fitter_.mind_the_worst()) return false;
            fitter_.weights();
            fitter_.remove_idle();
            if (largest_of(fitter_.fit().largest_squares(running_)) <= options_.max_distance &&
                holds(fitter_.fit()))
                best_ = fitter_.fit();
        }
        return true;
    }
    bool start(std::size_t bones) {
        count(4, bones);
        return fitter_.start(bones);
    }
    /// Goes over to another number of bones.
    bool change(std::size_t bones) {
        for (std::size_t move = 0; move < moves_; ++move) {
            count(4, bones);
            if (!fitter_.exchange(bones, (std::max)(std::size_t{1}, bones / 6))) return false;
        }
        return true;
    }
    /// Rounds in which bones mind the vertices beyond the distance, until there are none.
    template <class Holds>
    bool polish(const Holds& holds) {
        const std::size_t rounds = fitter_.fit().bones() > 1 ? options_.rounds : 0;
        largest_ = std::numeric_limits<double>::infinity();
        found_ = false;
        for (std::size_t n = 0;; ++n) {
            fitter_.weights();
            fitter_.remove_idle();
            std::vector<double> squares = fitter_.fit().largest_squares(running_);
            const double now = largest_of(squares);
            largest_ = (std::fmin)(largest_, now);
            found_ = now <= options_.max_distance && holds(fitter_.fit());
            if (found_ || !best_ || now < nearest_) {
                best_ = fitter_.fit();
                nearest_ = found_ ? 0 : now;
            }
            if (found_ || n == rounds) break;
            for (double& x : squares) x /= options_.max_distance * options_.max_distance;
            count(1, fitter_.fit().bones());
            if (!fitter_.mind(squares, n == 0)) return false;
        }
        trials_.push_back({fitter_.fit().bones(), found_});
        return true;
    }
    static double largest_of(const std::vector<double>& squares) {
        return std::sqrt(*std::max_element(squares.begin(), squares.end()));
    }

    /// The cost of a round grows with the bones, but not from 0.
    static double cost(std::size_t rounds, std::size_t bones) noexcept {
        return double(rounds) * double(bones + 12);
    }
    void count(std::size_t rounds, std::size_t bones) noexcept { work_ += cost(rounds, bones); }
    /// Whether there is work left to try so many bones.
    bool is_affordable(std::size_t bones) const noexcept {
        return work_ + cost(4 * moves_ + options_.rounds, bones) <
               2.5 * cost(4 + 4 * options_.moves + options_.rounds, bones);
    }

    const SkeletonOptions& options_;
    const Running& running_;
    std::size_t moves_; ///< of idle bones for each number
    SkeletonFitter fitter_;
    std::optional<BoneFit> best_;
    double nearest_ = 0; ///< the largest distance of the best; 0: it holds
    double largest_ = 0; ///< the least largest distance in the last trial
    double work_ = 0;
    bool found_ = false; ///< whether the last trial holds
    std::vector<Trial> trials_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
