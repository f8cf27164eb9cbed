// Elastic, heavy cable after Irvine. SPDX-License-Identifier: Apache-2.0
//
// Equations: the docstring of this package. Solved in S, the sum of the tensions at both ends, from which all else
// follows; the equation is monotone in S, so that Newton's method with a bracket always ends. A cable that is taut or
// nearly so is solved in S, with series in place of logarithms, a slack one in theta = atanh(w L / S).
#pragma once

#include <cdpr/cables/bent_cable.hpp>
#include <cdpr/lanes.hpp>

namespace cdpr::CDPR_TARGET {

struct Catenary {
    static constexpr int STIFFNESS = 0, DENSITY = 1, DAMPING = 2;
    static constexpr int MOST = 120, NEWTON = 30;  // iterations; the others bisect
    static constexpr double ENOUGH = 1e-8;         // relative step: the error after it is about its square
    static constexpr double TIGHT = 1e-15;         // relative width of a bracket without numbers within
    static constexpr double SHALLOW = 0.4;         // w L / S up to which the parabola is a start
    static constexpr double VERTICAL = 1e-12;      // horizontal share of a cable that hangs vertically

    // Cable: horizontal and vertical distance of its ends, m, up to the exit, and their distance; weight per length,
    // N/m; 1 / (2 E A), 1/N; unwound length and length on the exit, m; whether `share` is needed.
    struct Cable {
        double across, rise, chord, weight, compliance, unwound, wrapped;
        bool damped;
    };

    // Solution: S, N; unstretched length of the span, m; the horizontal force per `across`, N/m; the vertical force in
    // the middle of the cable, N; mean strain; the share of a change of the chord that stretches the cable.
    template <class T> struct Shape {
        T sum, span, pull, middle, strain, share;
    };

    // (q - 1) / x, with q = atanh(z) / z and x = z^2.
    static CDPR_INLINE double excess(double z, double x) {
        if (!(x < 0.01)) return (0.5 * ::log1p(2.0 * z / (1.0 - z)) / z - 1.0) / x;
        const double x2 = x * x, x4 = x2 * x2;
        const double low = (1.0 / 3 + x * (1.0 / 5)) + x2 * (1.0 / 7 + x * (1.0 / 9));
        const double high = (1.0 / 11 + x * (1.0 / 13)) + x2 * (1.0 / 15 + x * (1.0 / 17));
        return low + x4 * high;
    }

    static CDPR_INLINE Shape<double> unknown() {
        const double nan = NOT_A_NUMBER;
        return {nan, nan, nan, nan, nan, nan};
    }

    // Return the shape for a sum of tensions and q - 1; `steepness` is 1 - (w L / S)^2.
    static CDPR_INLINE Shape<double> shape(const Cable& cable, double sum, double less, double steepness) {
        const double strain = cable.compliance * sum, grown = 1.0 + strain;
        const double length = cable.unwound * grown - cable.wrapped, span = length / grown;
        const double along = 1.0 + less + strain, half = 0.5 * sum;
        const double pull = half / (span * along), middle = half * cable.rise / length;
        if (!cable.damped) return {sum, span, pull, middle, strain, 0.0};
        // The semi-axes' parts of the stretched length, as in `taut`; both times 1 + strain.
        const double square = 1.0 / (along * along * steepness), reach = cable.across * grown * square;
        const double stiff = cable.rise * cable.rise * strain + reach * reach * grown * (strain + less) * along;
        const double share = strain * length * length * length / (stiff * cable.chord);
        return {sum, span, pull, middle, strain, share < 1.0 ? share : stiff > 0.0 ? 1.0 : 0.0};
    }

    // Return the shape for a sum of tensions of a cable that is not slack.
    static CDPR_INLINE Shape<double> shape(const Cable& cable, double sum) {
        const double reach = cable.unwound - cable.wrapped / (1.0 + cable.compliance * sum);
        const double z = cable.weight * reach / sum, x = z * z;
        return shape(cable, sum, x * excess(z, x), 1.0 - x);
    }

    // Return iterate i: `next` of Newton's method, or without its progress another within the bracket.
    static CDPR_INLINE double within(double low, double high, double now, double next, int i) {
        if (i < NEWTON && next > low && next < high) return next;
        return high < INFINITE ? 0.5 * (low + high) : 2.0 * now;
    }

    // Newton's method for the positive root of a S^3 - b S^2 - c, a > 0, c >= 0, from above, where it is convex.
    static CDPR_INLINE double cubic(double a, double b, double c, double S) {
        for (int i = 0; i < 2; i++) S = S - (S * S * (a * S - b) - c) / (S * (3.0 * a * S - 2.0 * b));
        return S;
    }

    // Return the sum of tensions of a parabola, corrected to the next order.
    static CDPR_INLINE double parabola(const Cable& cable) {
        const double a = cable.unwound * cable.compliance, b = cable.chord + cable.wrapped - cable.unwound;
        const double linear = b > 0.0 ? b / a : 0.0;
        if (!(cable.across > 0.0)) return linear;
        const double flat = cable.across * (cable.across / cable.chord), w = cable.weight * cable.weight;
        const double reach = cable.unwound - cable.wrapped, c = flat * w * reach * reach / 6.0;
        const double beyond = c / (a * linear * linear);
        double S = linear + (beyond < linear ? beyond : ::cbrt(c / a));
        if (b < 0.0) {
            const double slack = ::sqrt(-c / b);
            S = slack < S ? slack : S;
        }
        if (!(beyond < 0.02 * linear)) S = cubic(a, b, c, S);
        const double strain = cable.compliance * S, per = 1.0 / (1.0 + strain),
                     span = cable.unwound - cable.wrapped * per;
        const double x = w * span * span / (S * S), level = flat / cable.chord;
        if (x > 0.02) return cubic(a, b, c, S);
        const double more = ((1.0 + 3.0 * strain) * per + 0.8 * x) * (1.0 - x * level / 12.0);
        return cubic(a, b, flat * w * span * span * more / 6.0, S);
    }

    // Return the shape of a cable that is not slack, from a first guess of S.
    static CDPR_INLINE Shape<double> taut(const Cable& cable, double sum) {
        const double slack = cable.unwound - cable.wrapped - cable.chord, across = cable.across * cable.across;
        const double rise = cable.rise * cable.rise;
        double low = 0.0, high = INFINITE;
        for (int i = 0; i < MOST; i++) {
            const double a = cable.compliance * sum, per = 1.0 / (1.0 + a);
            const double span = cable.unwound - cable.wrapped * per;
            const double z = cable.weight * span / sum, x = z * z;
            double step = INFINITE, less = 0.0, slope_of_less = 0.0;
            bool below = true;
            if (span > 0.0 && z < 1.0) {
                const double e = excess(z, x), grown = 1.0 + a;
                less = x * e;
                const double along = grown + less;
                const double square = 1.0 / (along * along * (1.0 - x)), level = across * grown * grown * square;
                slope_of_less = less - x * along * along * square;
                const double root = ::sqrt(rise + level);
                const double sag = across * x * (along * along - e * (grown + along)) * square / (root + cable.chord);
                const double miss = cable.unwound * a + slack - sag;
                const double stiff = rise * a * per + level * (a + less) * along * square;
                const double slope = ((cable.unwound - span) * a + a * miss * per) * root + stiff;
                step = -sum * miss * root / slope;
                below = miss < 0.0;
            }
            (below ? low : high) = sum;
            if (absolute(step) <= ENOUGH * sum) {
                const double r = step / sum;  // d less / d ln S = less - x / (1 - x)
                return x < 0.1 ? shape(cable, sum + step, less + r * slope_of_less, 1.0 - x * (1.0 - 2.0 * r))
                               : shape(cable, sum + step);
            }
            if (high - low <= TIGHT * sum) return shape(cable, sum);
            sum = within(low, high, sum, sum + step, i);
        }
        return unknown();
    }

    // Return the strain at theta, with the tension sum w L / tanh(theta) of the length L at that strain.
    static CDPR_INLINE double strain_at(const Cable& cable, double tangent) {
        const double k = cable.compliance * cable.weight / tangent;
        const double free = 1.0 - k * cable.unwound, rest = 4.0 * k * (cable.unwound - cable.wrapped);
        return 0.5 * rest / (free + ::sqrt(free * free + rest));
    }

    // Return the square of the span less that of its height, both unstretched, m^2.
    static CDPR_INLINE double beyond(const Cable& cable, double strain) {
        const double height = absolute(cable.rise), grown = 1.0 + strain;
        const double more = cable.unwound * strain + (cable.unwound - cable.wrapped - height);
        return more * (more + 2.0 * height) / (grown * grown);
    }

    // Return the shape of a slack cable that does not hang vertically.
    static CDPR_INLINE Shape<double> slack(const Cable& cable, double theta) {
        double low = 0.0, high = INFINITE;
        for (int i = 0; i < MOST; i++) {
            const double more = ::expm1(theta), less = 1.0 / (more + 1.0);
            const double sinh = 0.5 * (more + more * less), cosh = 1.0 + 0.5 * more * more * less;
            const double tangent = sinh / cosh, a = strain_at(cable, tangent), grown = 1.0 + a;
            const double height = absolute(cable.rise) / grown;
            const double square = beyond(cable, a);
            const double level = theta / sinh + a / cosh;
            const double change = -a / (sinh * cosh);
            const double turn = (1.0 - theta / tangent) / sinh + (change - a * tangent) / cosh;
            const double slope = turn / level + height * height * change / (grown * square);
            const double miss = 0.5 * ::log(level * level * square / (cable.across * cable.across));
            (miss > 0.0 ? low : high) = theta;  // NaN beyond the longest span
            const double step = -miss / slope;
            const bool tight = high - low <= TIGHT * theta;
            if (absolute(step) <= ENOUGH * theta || tight) {
                theta = tight ? theta : theta + step;
                const double end = ::tanh(theta), edge = 1.0 / ::cosh(theta);
                const double sum = strain_at(cable, end) / cable.compliance;
                return shape(cable, sum, theta / end - 1.0, edge * edge);
            }
            theta = within(low, high, theta, theta + step, i);
        }
        return unknown();
    }

    // Return the shape of a cable whose ends are one above the other.
    static CDPR_INLINE Shape<double> vertical(const Cable& cable) {
        const double pulled = absolute(cable.rise) + cable.wrapped;
        const double sum = (pulled - cable.unwound) / (cable.unwound * cable.compliance);
        const double resting = strain_at(cable, 1.0);
        if (cable.compliance * sum > (1.0 + TIGHT) * resting) return shape(cable, sum);
        const double span = cable.unwound - cable.wrapped / (1.0 + resting);
        const double rest = resting / cable.compliance;
        return {rest, span, 0.0, 0.5 * rest * cable.rise / (span * (1.0 + resting)), resting, 0.0};
    }

    // Return the shape of a cable without weight: that of an elastic one.
    static CDPR_INLINE Shape<double> weightless(const Cable& cable) {
        const double sum = (cable.chord + cable.wrapped - cable.unwound) / (cable.unwound * cable.compliance);
        if (!(sum > 0.0)) return {0.0, cable.unwound - cable.wrapped, 0.0, 0.0, 0.0, 0.0};
        return shape(cable, sum, 0.0, 1.0);
    }

    // Return the shape of a cable; NaN if there is none. Always from a cold start, so that it depends on nothing else.
    static CDPR_INLINE Shape<double> hang(double across, double rise, double chord, double weight, double compliance,
                                          double unwound, double wrapped, bool damped) {
        const Cable cable = {across, rise, chord, weight, compliance, unwound, wrapped, damped};
        if (!(unwound > 0.0 && compliance > 0.0 && chord + wrapped + weight < INFINITE && unwound < INFINITE))
            return unknown();
        if (!(weight > 0.0)) return weightless(cable);
        const double sum = parabola(cable);
        if (weight * (unwound > wrapped ? unwound - wrapped : 0.0) <= SHALLOW * sum) return taut(cable, sum);
        if (across <= VERTICAL * (absolute(rise) + unwound)) return vertical(cable);
        const double square = beyond(cable, strain_at(cable, 1.0));
        const double ratio = square > 0.0 ? ::sqrt(square) / across : 1.0;
        double theta = SHALLOW;
        if (ratio > 3.0)
            theta = ::log(2.0 * ratio * ::log(2.0 * ratio * ::log(2.0 * ratio)));
        else if (ratio > 1.0)
            theta = ::sqrt(3.0 * (ratio * ratio - 1.0));
        return slack(cable, theta > SHALLOW ? theta : SHALLOW);
    }

#ifdef CDPR_LANES
    static inline Shape<Lanes> hang(const Lanes& across, const Lanes& rise, const Lanes& chord, const Lanes& weight,
                                    const Lanes& compliance, const Lanes& unwound, const Lanes& wrapped,
                                    const Mask& damped) {
        Shape<Lanes> found = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
        for (int i = 0; i < WIDTH; i++) {
            const Shape<double> one = hang(across.get(i), rise.get(i), chord.get(i), weight.get(i), compliance.get(i),
                                           unwound.get(i), wrapped.get(i), damped.get(i));
            found.sum.set(i, one.sum);
            found.span.set(i, one.span);
            found.pull.set(i, one.pull);
            found.middle.set(i, one.middle);
            found.strain.set(i, one.strain);
            found.share.set(i, one.share);
        }
        return found;
    }
#endif

    // Return the unstretched length, m, of a taut span for S: the smaller of two; NaN if there is none.
    static inline double length_for(double across, double rise, double weight, double strain, double sum) {
        const double grown = 1.0 + strain, level = across * across, height = rise * rise;
        double span = ::sqrt(level + height) / grown;
        for (int i = 0; i < MOST; i++) {
            const double z = weight > 0.0 ? weight * span / sum : 0.0, x = z * z;
            if (!(z < 1.0)) return NOT_A_NUMBER;
            const double less = x * excess(z, x), along = 1.0 + less + strain, steepness = 1.0 - x;
            const double ratio = grown * grown / (along * along * steepness);
            const double root = ::sqrt(height + level * ratio), miss = span * grown - root;
            const double slope = grown - level * ratio * (less + x * strain) / (along * steepness * span * root);
            if (!(slope > 0.0)) return miss < 0.0 ? NOT_A_NUMBER : span;
            const double step = -miss / slope;
            span = span + step;
            if (absolute(step) <= ENOUGH * span) return span;
        }
        return NOT_A_NUMBER;
    }

#ifdef CDPR_LANES
    static inline Lanes length_for(const Lanes& across, const Lanes& rise, const Lanes& weight, const Lanes& strain,
                                   const Lanes& sum) {
        Lanes found = 0.0;
        for (int i = 0; i < WIDTH; i++)
            found.set(i, length_for(across.get(i), rise.get(i), weight.get(i), strain.get(i), sum.get(i)));
        return found;
    }
#endif

    // Directions and numbers of a cable.
    template <class T> struct Frame {
        Vector<T> up, across;
        T level, rise, chord, weight, compliance, climb;  // climb: weight of the cable's rise on the exit, N

        CDPR_INLINE Frame(const BentSpan<T>& span) {
            const T g = length(span.gravity);
            up = select(g > T(0.0), (-1.0 / g) * span.gravity, Vector<T>{0.0, 0.0, 0.0});
            rise = dot(span.chord, up);
            across = span.chord - rise * up;
            const T square = dot(across, across);
            level = square_root(square);
            chord = square_root(square + rise * rise);
            weight = span.numbers[DENSITY] * g;
            compliance = 0.5 / span.numbers[STIFFNESS];
            climb = select(span.wrapped_length > T(0.0), weight * dot(span.exit_to_anchor, up), T(0.0));
        }

        // Return the tension, N, further along the exit, where the cable is higher by `lift` of weight, N.
        CDPR_INLINE T carried(T tension, T lift) const {
            if (all(lift == T(0.0))) return tension;
            const T sum = tension * (1.0 + compliance * tension) + lift;
            const T there = 2.0 * sum / (1.0 + square_root(1.0 + 4.0 * compliance * sum));
            return select(lift == T(0.0), tension, there);
        }
    };

    // Return force and tension of a cable with this unwound length, m, and rate of stretch, m/s.
    template <class T> static CDPR_INLINE BentCable<T> pull(BentSpan<T> span, T unwound, T stretching, T lowest) {
        const Frame<T> at(span);
        const T damper = span.numbers[DAMPING] * stretching;
        const Shape<T> shape =
            hang(at.level, at.rise, at.chord, at.weight, at.compliance, unwound, span.wrapped_length, damper != T(0.0));
        const T along = (shape.pull * at.level * at.level + shape.middle * at.rise) / at.chord;
        const T damping = select(damper != T(0.0), larger(damper * shape.share, -along), T(0.0));
        const Vector<T> chordal = select(at.chord > T(0.0), (damping / at.chord) * span.chord, T(0.0) * at.up);
        const Vector<T> middle = shape.pull * at.across + shape.middle * at.up + chordal;
        const T half = 0.5 * at.weight * shape.span;
        const T tension = at.carried(length(middle + half * at.up), at.climb);
        return {middle - half * at.up, select(lowest < T(0.0), T(NOT_A_NUMBER), tension)};
    }

    // Return the unwound length, m, of a taut cable with this tension, N, at the winch; NaN below the least tension.
    template <class T> static CDPR_INLINE T rest(BentSpan<T> span, T tension) {
        const Frame<T> at(span);
        const T at_exit = at.carried(tension, -at.climb);
        const T t = 2.0 * at.compliance * at_exit, k = at.compliance * at.weight * at.rise;
        const T strain = 2.0 * (t - k) / (1.0 - t + square_root((1.0 + t) * (1.0 + t) - 4.0 * k));
        const T length = length_for(at.level, at.rise, at.weight, strain, strain / at.compliance);
        const T unwound = length + span.wrapped_length / (1.0 + strain);
        return select((strain >= T(0.0)) & (at_exit >= T(0.0)), unwound, T(NOT_A_NUMBER));
    }
};

}  // namespace cdpr::CDPR_TARGET
