#pragma once

// A wave function on a lattice. A product formula of fourth order advances it in time.

#include <cageform/parallel/threads.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstring>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

namespace cageform_sources {

/// Points (i, j) · mesh, 0 ≤ i < columns, 0 ≤ j < rows; row 0 first. One row is a lattice of one dimension.
struct WaveLattice {
    std::size_t columns = 0, rows = 1;
    double mesh = 0.1; ///< the distance between neighbours, in wavelengths

    std::size_t size() const { return columns * rows; }
    double x(std::size_t i) const { return mesh * double(i); }
    double y(std::size_t j) const { return mesh * double(j); }
    double width() const { return mesh * double(columns - 1); }
    double height() const { return mesh * double(rows - 1); }
};

/// The terms of H that are constant in time: one value per point, or empty for 0.
struct WaveTerms {
    std::vector<double> potential; ///< V
    std::vector<double> bonds;     ///< magnetic field: ∫A from a point to the point below it, in radians
    std::vector<double> losses;    ///< absorbing walls: Φ is multiplied by e^{−loss · time}
};

/// Φ in i ∂Φ/∂t = HΦ, H = −(1/4π²)∇² + V, in units of the Fermi wavelength, the Fermi energy E_F and ħ/E_F.
/// The phase of a free electron of energy 1 changes by 2π per wavelength; its speed is 1/π.
///
///   T          float for pictures, double to measure
///   outside    Φ is 0 outside the lattice, so its sides reflect
///   Laplacian  of fourth order in the mesh, by the two nearest points on each side of each axis
///   time       S₄(τ) = S₂(pτ)² S₂((1 − 4p)τ) S₂(pτ)², of fourth order in the step τ. S₂ is a symmetric
///              product of rotations of pairs of points. Rotations keep the norm, so any τ is stable.
///   accuracy   the error grows like (τ‖H‖)⁴; ‖H‖ is about 4/(3π² mesh²) per axis, plus the largest V
///   cost       about 80 passes over Φ per step, in blocks that stay in the cache
///   threads    the result does not depend on them
/// Suzuki, Physics Letters A 146 (1990), 319–323; De Raedt, Michielsen, Computers in Physics 8 (1994), 600.
template <class T>
class LatticeWave {
public:
    LatticeWave(const WaveLattice& lattice, WaveTerms terms, unsigned threads = 1)
        : lattice_(lattice)
        , terms_(std::move(terms))
        , parallel_{threads}
        , stride_((lattice.columns + lanes - 1) / lanes * lanes)
        , re_(stride_ * lattice.rows)
        , im_(re_.size()) {
        terms_.potential.resize(lattice_.size());
        for (std::size_t reach = 1; reach <= 2 && !terms_.bonds.empty(); ++reach) {
            Factor& phase = phases_[reach - 1];
            phase = Factor{std::vector<T>(re_.size(), T(1)), std::vector<T>(re_.size())};
            for (std::size_t n = 0; n + reach * lattice_.columns < lattice_.size(); ++n)
                phase.set(at(n), bond(n, reach), 1);
        }
    }

    const WaveLattice& lattice() const { return lattice_; }
    std::complex<double> value(std::size_t n) const { return {double(re_[at(n)]), double(im_[at(n)])}; }
    void set(std::size_t n, const std::complex<double>& value) {
        re_[at(n)] = T(value.real());
        im_[at(n)] = T(value.imag());
    }
    double density(std::size_t n) const { return std::norm(value(n)) * cell(); }

    /// Sets Φ to a function of x and y, scaled to norm 1.
    void start(const std::function<std::complex<double>(double, double)>& function) {
        std::vector<std::complex<double>> values(lattice_.size());
        double sum = 0;
        for (std::size_t n = 0; n < values.size(); ++n) {
            values[n] = function(lattice_.x(n % lattice_.columns), lattice_.y(n / lattice_.columns));
            sum += std::norm(values[n]) * cell();
        }
        for (std::size_t n = 0; n < values.size(); ++n) set(n, values[n] / std::sqrt(sum));
    }

    /// Chooses the step τ for advance(); a negative one goes back in time.
    void set_step(double step) {
        step_ = step;
        factors_[inner] = factor_between(p, p);
        factors_[middle] = factor_between(p, 1 - 4 * p);
        factors_[first] = factor_between(0, p);
        if (terms_.losses.empty()) return;
        factors_[last] = factor_between(p, 0, step);
        factors_[between] = factor_between(p, p, step);
    }

    /// Advances by `steps` steps.
    void advance(std::size_t steps) {
        if (steps == 0) return;
        constexpr std::array shares{p, p, 1 - 4 * p, p, p};
        constexpr std::array diagonals{inner, middle, middle, inner};
        const bool absorbs = !terms_.losses.empty();
        along_rows(0, first, shares[0]);
        for (std::size_t step = 0; step < steps; ++step) {
            for (std::size_t k = 0; k < shares.size(); ++k) {
                down_columns(shares[k]);
                if (k < diagonals.size()) along_rows(shares[k], diagonals[k], shares[k + 1]);
            }
            if (step + 1 < steps)
                along_rows(p, absorbs ? between : inner, p);
            else
                along_rows(p, absorbs ? last : first, 0);
        }
    }

    /// Advances by one step of S₂, for comparison.
    void advance_second_order() {
        factors_[first] = factor_between(0, 1);
        along_rows(0, first, 1);
        down_columns(1);
        along_rows(1, first, 0);
    }

    /// HΦ at a point.
    std::complex<double> hamiltonian(std::size_t n) const {
        const std::size_t columns = lattice_.columns, i = n % columns, j = n / columns;
        const auto axis = [&](std::size_t place, std::size_t count, std::size_t stride, bool turned) {
            const auto side = [&](std::size_t other, std::size_t upper, std::size_t reach, double sign) {
                const double weight = reach == 1 ? -4.0 / 3 : 1.0 / 12;
                return weight * value(other) * (turned ? std::polar(1.0, sign * bond(upper, reach)) : 1.0);
            };
            std::complex<double> sum = 2.5 * value(n);
            for (std::size_t reach = 1; reach <= 2; ++reach) {
                const std::size_t away = reach * stride;
                if (place >= reach) sum += side(n - away, n - away, reach, 1);
                if (place + reach < count) sum += side(n + away, n, reach, -1);
            }
            return sum;
        };
        std::complex<double> sum = axis(i, columns, 1, false);
        if (lattice_.rows > 1) sum += axis(j, lattice_.rows, columns, !terms_.bonds.empty());
        return coupling() * sum + terms_.potential[n] * value(n);
    }

    double norm() const {
        return sum_of([](std::size_t) { return 1.0; });
    }
    /// ∑ of w(n) |Φ|² over all points n.
    double sum_of(const std::function<double(std::size_t)>& weight) const {
        double sum = 0;
        for (std::size_t n = 0; n < lattice_.size(); ++n) sum += weight(n) * density(n);
        return sum;
    }
    /// The mean energy of the part with x ≥ `from`, by default of all; 0 if Φ is 0 there.
    double energy(double from = -1) const {
        double sum = 0, part = 0;
        for (std::size_t n = 0; n < lattice_.size(); ++n) {
            if (lattice_.x(n % lattice_.columns) < from) continue;
            sum += (std::conj(value(n)) * hamiltonian(n)).real() * cell();
            part += density(n);
        }
        return part > 0 ? sum / part : 0;
    }

private:
    static constexpr double p = 0.4144907717943757; // 1/(4 − ∛4)
    static constexpr std::size_t lanes = 8;
    typedef T Pack __attribute__((vector_size(lanes * sizeof(T))));
    enum Diagonal { inner, middle, first, last, between };

    /// One complex factor per point.
    struct Factor {
        std::vector<T> re, im;
        void set(std::size_t place, double angle, double size) {
            re[place] = T(size * std::cos(angle));
            im[place] = T(size * std::sin(angle));
        }
    };

    std::size_t at(std::size_t n) const { return n / lattice_.columns * stride_ + n % lattice_.columns; }
    double cell() const { return lattice_.rows > 1 ? lattice_.mesh * lattice_.mesh : lattice_.mesh; }
    double coupling() const {
        return 1 / (4 * std::numbers::pi * std::numbers::pi * lattice_.mesh * lattice_.mesh);
    }
    /// ∫A from a point to the point `reach` rows below: 1 or 2.
    double bond(std::size_t n, std::size_t reach) const {
        return terms_.bonds[n] + (reach == 2 ? terms_.bonds[n + lattice_.columns] : 0.0);
    }
    /// The cosine and sine of the rotation of pairs `reach` points apart (1 or 2), in a share of the step.
    std::array<T, 2> turn(std::size_t reach, double share) const {
        const double angle = step_ * share * coupling() * (reach == 1 ? -4.0 / 3 : 1.0 / 12);
        return {T(std::cos(angle)), T(std::sin(angle))};
    }
    /// The relative growth of Φ in one S₂, because cosine and sine are rounded; for points away from the
    /// sides.
    double growth(double share) const {
        const auto of = [&](std::size_t reach, double part) {
            const std::array<T, 2> rounded = turn(reach, part);
            const auto c = static_cast<long double>(rounded[0]), s = static_cast<long double>(rounded[1]);
            return double(c * c + s * s - 1) / 2;
        };
        const double near = 4 * of(1, share / 2), far = of(2, share / 2);
        return near + 4 * far + (lattice_.rows > 1 ? near + 2 * far + of(2, share) : 0.0);
    }
    /// The diagonal factors e^{−iτD} between two S₂, half of each. They also cancel growth().
    Factor factor_between(double before, double after, double loss_time = 0) const {
        Factor factor{std::vector<T>(re_.size()), std::vector<T>(re_.size())};
        const double time = (before + after) / 2 * step_;
        const double kinetic = 2.5 * coupling() * (lattice_.rows > 1 ? 2 : 1);
        const double grown = (growth(before) + growth(after)) / 2;
        for (std::size_t n = 0; n < lattice_.size(); ++n) {
            const double lost = loss_time == 0 ? 0 : std::fabs(loss_time) * terms_.losses[n];
            factor.set(at(n), -time * (kinetic + terms_.potential[n]), std::exp(-grown - lost));
        }
        return factor;
    }

    static void load(Pack& pack, const T* from) { std::memcpy(&pack, from, sizeof(pack)); }
    static void store(T* to, const Pack& pack) { std::memcpy(to, &pack, sizeof(pack)); }

    /// Turns the pairs (j, j + Reach) of a row, from `begin` on: e^{−iaσ} with c = cos a, s = sin a.
    template <std::size_t Reach>
    static void turn_pairs(T* re, T* im, std::size_t begin, std::size_t end, T c, T s) {
        std::size_t j = begin;
        for (; j + lanes <= end; j += lanes) {
            Pack a, b, other_a, other_b;
            load(a, re + j);
            load(b, im + j);
            if constexpr (Reach == 1) {
                other_a = __builtin_shufflevector(a, a, 1, 0, 3, 2, 5, 4, 7, 6);
                other_b = __builtin_shufflevector(b, b, 1, 0, 3, 2, 5, 4, 7, 6);
            } else {
                other_a = __builtin_shufflevector(a, a, 2, 3, 0, 1, 6, 7, 4, 5);
                other_b = __builtin_shufflevector(b, b, 2, 3, 0, 1, 6, 7, 4, 5);
            }
            store(re + j, c * a + s * other_b);
            store(im + j, c * b - s * other_a);
        }
        for (; j + Reach < end; ++j) {
            if ((j - begin) % (2 * Reach) >= Reach) continue;
            const T a = re[j], b = im[j], u = re[j + Reach], v = im[j + Reach];
            re[j] = c * a + s * v;
            im[j] = c * b - s * u;
            re[j + Reach] = c * u + s * b;
            im[j + Reach] = c * v - s * a;
        }
    }

    /// Processes row by row, so that rows stay in the cache: the second half of one S₂, the diagonals, the
    /// first half of the next.
    void along_rows(double before, Diagonal diagonal, double after) {
        const std::size_t n = lattice_.columns;
        const auto groups = [n](T* re, T* im, std::size_t group, T c, T s) {
            if (group == 0) turn_pairs<1>(re, im, 0, n, c, s);
            if (group == 1) turn_pairs<1>(re, im, 1, n, c, s);
            if (group == 2) turn_pairs<2>(re, im, 0, n, c, s);
            if (group == 3) turn_pairs<2>(re, im, 2, n, c, s);
        };
        std::array<std::array<T, 2>, 4> turns{}; // cos, sin: near and far pairs, before and after
        for (std::size_t k = 0; k < 4; ++k) turns[k] = turn(1 + k % 2, (k < 2 ? before : after) / 2);
        const Factor& factor = factors_[diagonal];
        parallel_(lattice_.rows, grain(n), [&](std::size_t begin, std::size_t end) {
            for (std::size_t j = begin; j < end; ++j) {
                T *const re = &re_[j * stride_], *const im = &im_[j * stride_];
                for (std::size_t g = 4; before != 0 && g-- > 0;)
                    groups(re, im, g, turns[g / 2][0], turns[g / 2][1]);
                for (std::size_t i = 0; i < stride_; i += lanes) {
                    Pack a, b, c, d;
                    load(a, re + i);
                    load(b, im + i);
                    load(c, &factor.re[j * stride_ + i]);
                    load(d, &factor.im[j * stride_ + i]);
                    store(re + i, a * c - b * d);
                    store(im + i, a * d + b * c);
                }
                for (std::size_t g = 0; after != 0 && g < 4; ++g)
                    groups(re, im, g, turns[2 + g / 2][0], turns[2 + g / 2][1]);
            }
        });
    }

    /// Turns all pairs of rows of a group between two columns. With a magnetic field the rotation has a
    /// phase: ⟨j|H|j + 1⟩ = a e^{−iθ}.
    template <std::size_t Reach, bool Field>
    void turn_rows(std::size_t from, std::size_t left, std::size_t right, T c, T s) {
        for (std::size_t j = from; j + Reach < lattice_.rows; ++j) {
            if ((j - from) % (2 * Reach) >= Reach) continue;
            T *const re = &re_[j * stride_], *const im = &im_[j * stride_];
            const std::size_t below = Reach * stride_;
            for (std::size_t i = left; i < right; i += lanes) {
                Pack a, b, u, v;
                load(a, re + i);
                load(b, im + i);
                load(u, re + below + i);
                load(v, im + below + i);
                if constexpr (Field) {
                    Pack cosine, sine;
                    load(cosine, &phases_[Reach - 1].re[j * stride_ + i]);
                    load(sine, &phases_[Reach - 1].im[j * stride_ + i]);
                    cosine *= s;
                    sine *= s;
                    store(re + i, c * a - sine * u + cosine * v);
                    store(im + i, c * b - cosine * u - sine * v);
                    store(re + below + i, c * u + sine * a + cosine * b);
                    store(im + below + i, c * v - cosine * a + sine * b);
                } else {
                    store(re + i, c * a + s * v);
                    store(im + i, c * b - s * u);
                    store(re + below + i, c * u + s * b);
                    store(im + below + i, c * v - s * a);
                }
            }
        }
    }

    /// Turns pairs of rows, in blocks of columns that stay in the cache. The order of the groups is
    /// symmetric.
    template <bool Field>
    void down_columns_by(double share) {
        constexpr std::size_t block = 512 / sizeof(T);
        const std::size_t blocks = (stride_ + block - 1) / block;
        const std::array turns{turn(1, share / 2), turn(2, share / 2), turn(2, share)};
        parallel_(blocks, grain(lattice_.rows * block), [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const std::size_t left = k * block, right = std::min(left + block, stride_);
                const auto near = [&](std::size_t from) {
                    turn_rows<1, Field>(from, left, right, turns[0][0], turns[0][1]);
                };
                const auto far = [&](std::size_t from, std::size_t times) {
                    turn_rows<2, Field>(from, left, right, turns[times][0], turns[times][1]);
                };
                near(0);
                near(1);
                far(0, 1);
                far(2, 2);
                far(0, 1);
                near(1);
                near(0);
            }
        });
    }
    void down_columns(double share) {
        if (lattice_.rows < 2) return;
        terms_.bonds.empty() ? down_columns_by<false>(share) : down_columns_by<true>(share);
    }

    /// Rows or blocks per task: about 16,384 points.
    static std::size_t grain(std::size_t points) { return std::max<std::size_t>(1, 16384 / points); }

    WaveLattice lattice_;
    WaveTerms terms_;
    cageform::ThreadedFor parallel_;
    std::size_t stride_; // of a row, in numbers
    std::vector<T> re_, im_;
    std::array<Factor, 5> factors_;
    std::array<Factor, 2> phases_; // of pairs one and two rows apart
    double step_ = 0;
};

} // namespace cageform_sources
