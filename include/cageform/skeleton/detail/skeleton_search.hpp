// Searches for the fewest bones that keep all vertices within a distance.
#pragma once

#include <cageform/skeleton/detail/skeleton_fitter.hpp>

#include <limits>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Runs short fits with more and more bones until one is within the distance, then removes bones while the
/// limit holds. The total cost is limited to two and a half times the cost of a fit by number.
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
        , fitter_(motion, options, running)
        , best_(fitter_.fit()) {}

    /// The valid fit with the fewest bones; if there is none, the one with the smallest distance.
    const BoneFit& best() const noexcept { return best_; }
    /// Numbers of bones tried, in order.
    const std::vector<Trial>& trials() const noexcept { return trials_; }

    /// Tries 1 to `most` bones; holds(fit) returns true if a fit, rounded as it is stored, is within the
    /// distance.
    template <class Holds>
    Status run(std::size_t most, const Holds& holds) {
        if (!start(1) || !polish(holds)) return Status::cancelled;
        if (found_ || most == 1) return Status::ok;
        std::size_t low = 1, high = (std::min)(most, std::size_t{4});
        if (!start(high) || !polish(holds)) return Status::cancelled;
        while (!found_) {
            if (high == most) return Status::ok;
            low = high;
            const double factor = std::pow(trial_distance_ / options_.max_distance, 0.7);
            const double next = double(low) * (std::fmin)((std::fmax)(factor, 1.1), 2.0);
            high = (std::min)((std::max)(low + 1, std::size_t(next)), most);
            // A large step restarts from clusters, which distribute many bones better.
            if (double(high) >= 1.3 * double(low) && !start(high)) return Status::cancelled;
            if (!change(high) || !polish(holds)) return Status::cancelled;
        }
        return shrink(low, holds) && smooth(holds) ? Status::ok : Status::cancelled;
    }

private:
    // Steps; they return false if cancelled.

    /// Removes bones from the fit found. If the fit then exceeds the distance, tries the same number of bones
    /// once more. If that fails too, returns to the best fit and removes fewer bones.
    template <class Holds>
    bool shrink(std::size_t low, const Holds& holds) {
        std::size_t high = best_.bones();
        std::size_t step = high > low ? (std::max)(std::size_t{1}, (high - low) / 2) : 1;
        bool again = true;
        while (high > step + 1 && is_affordable(high - step)) {
            if (!change(high - step) || !polish(holds)) return false;
            if (found_) {
                high = best_.bones();
                step = (std::max)(std::size_t{1}, high / 16);
                again = true;
            } else if (again) {
                again = false;
            } else if (step == 1) {
                break;
            } else {
                step /= 2;
                fitter_.restore(best_);
                again = true;
            }
        }
        return true;
    }
    /// Runs rounds as in a fit by number. They lower the mean distance.
    template <class Holds>
    bool smooth(const Holds& holds) {
        fitter_.restore(best_);
        for (std::size_t n = 0; n < options_.rounds / 2; ++n) {
            if (!fitter_.reweight_by_error()) return false;
            fitter_.weights();
            fitter_.remove_idle();
            if (largest_of(fitter_.fit().largest_squares(running_)) <= options_.max_distance &&
                holds(fitter_.fit()))
                best_ = fitter_.fit();
        }
        return true;
    }
    bool start(std::size_t bones) {
        spend(4, bones);
        return fitter_.start(bones);
    }
    /// Changes the number of bones.
    bool change(std::size_t bones) {
        for (std::size_t move = 0; move < moves_; ++move) {
            spend(4, bones);
            if (!fitter_.exchange(bones, (std::max)(std::size_t{1}, bones / 6))) return false;
        }
        return true;
    }
    /// Runs rounds in which vertices over the limit have more weight, until no vertex is over the limit.
    template <class Holds>
    bool polish(const Holds& holds) {
        const std::size_t rounds = fitter_.fit().bones() > 1 ? options_.rounds : 0;
        trial_distance_ = std::numeric_limits<double>::infinity();
        found_ = false;
        for (std::size_t n = 0;; ++n) {
            fitter_.weights();
            fitter_.remove_idle();
            std::vector<double> squares = fitter_.fit().largest_squares(running_);
            const double now = largest_of(squares);
            trial_distance_ = (std::fmin)(trial_distance_, now);
            found_ = now <= options_.max_distance && holds(fitter_.fit());
            if (found_ || best_.bones() == 0 || now < best_distance_) {
                best_ = fitter_.fit();
                best_distance_ = found_ ? 0 : now;
            }
            if (found_ || n == rounds) break;
            for (double& x : squares) x /= options_.max_distance * options_.max_distance;
            spend(1, fitter_.fit().bones());
            if (!fitter_.reweight(squares, n == 0)) return false;
        }
        trials_.push_back({fitter_.fit().bones(), found_});
        return true;
    }
    static double largest_of(const std::vector<double>& squares) {
        return std::sqrt(*std::max_element(squares.begin(), squares.end()));
    }

    /// Relative cost of rounds: linear in the number of bones, with a constant part.
    static double cost(std::size_t rounds, std::size_t bones) noexcept {
        return double(rounds) * double(bones + 12);
    }
    void spend(std::size_t rounds, std::size_t bones) noexcept { spent_ += cost(rounds, bones); }
    /// True if the remaining budget allows a trial with so many bones.
    bool is_affordable(std::size_t bones) const noexcept {
        return spent_ + cost(4 * moves_ + options_.rounds, bones) <
               2.5 * cost(4 + 4 * options_.moves + options_.rounds, bones);
    }

    const SkeletonOptions& options_;
    const Running& running_;
    std::size_t moves_; ///< relocations per number of bones
    SkeletonFitter fitter_;
    BoneFit best_;              ///< without bones before the first trial
    double best_distance_ = 0;  ///< maximum distance of the best fit; 0: within the limit
    double trial_distance_ = 0; ///< smallest maximum distance in the last trial
    double spent_ = 0;
    bool found_ = false; ///< true if the last trial is within the limit
    std::vector<Trial> trials_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
