// Curve of an elastic, heavy cable. SPDX-License-Identifier: Apache-2.0
//
// Irvine's equations in the form of this package's docstring, for the part of unstretched length s at the platform. The
// tension there is the horizontal force and V_0 + w s.
#pragma once

#include <cdpr/cables/catenary/catenary.hpp>

namespace cdpr::CDPR_TARGET {

struct CatenaryCurve {
    static constexpr int NUMBERS = 13;
    static constexpr double STEEP = 1e-16;  // 1 - w s / S of a cable that hangs vertically

    Vector<double> pull, up;               // N, horizontal force on the platform; vertical unit vector
    double lowest, weight, stretch, span;  // V_0, N; N/m; 1 / (E A), 1/N; unstretched length, m
    Vector<double> miss;                   // m, round-off of `raw` at the exit

    // Make the curve of a cable with an unwound length, m; NaN if it has no equilibrium.
    inline CatenaryCurve(const BentSpan<double>& cable, double unwound) {
        const Catenary::Frame<double> at(cable);
        const Catenary::Shape<double> shape =
            Catenary::hang(at.level, at.rise, at.chord, at.weight, at.compliance, unwound, cable.wrapped_length, false);
        pull = shape.pull * at.across, up = at.up, weight = at.weight, stretch = 2.0 * at.compliance, span = shape.span;
        lowest = shape.middle - 0.5 * weight * span;
        miss = cable.chord - raw(span);
    }

    inline explicit CatenaryCurve(const double* row)
        : pull(vector(row)),
          up(vector(row + 3)),
          lowest(row[6]),
          weight(row[7]),
          stretch(row[8]),
          span(row[9]),
          miss(vector(row + 10)) {}

    inline void write(double* row) const {
        store(pull, row), store(up, row + 3), store(miss, row + 10);
        row[6] = lowest, row[7] = weight, row[8] = stretch, row[9] = span;
    }

    // Return whether the curve differs from its chord.
    CDPR_INLINE bool sags() const { return weight > 0.0 && span > 0.0; }

    // Return the tension at an unstretched length s, m, as a vector towards the exit, N.
    CDPR_INLINE Vector<double> tension(double s) const { return pull + (lowest + weight * s) * up; }

    // Return the point at an unstretched length s, m, from the platform's end, m.
    CDPR_INLINE Vector<double> point(double s) const { return raw(s) + (s / span) * miss; }

  private:
    CDPR_INLINE Vector<double> raw(double s) const {
        const double sum = length(tension(0.0)) + length(tension(s)), share = weight * s / sum;
        const double most = 1.0 - STEEP, x = share < most ? share : most;
        const double grown = 1.0 + x * x * Catenary::excess(x, x * x);
        const double along = s * (stretch + 2.0 * grown / sum);
        const double risen = (lowest + 0.5 * weight * s) * s * (stretch + 2.0 / sum);
        return along * pull + risen * up;
    }
};

}  // namespace cdpr::CDPR_TARGET
