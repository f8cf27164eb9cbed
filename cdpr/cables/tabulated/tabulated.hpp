// Cable with a measured curve of tension over strain. SPDX-License-Identifier: Apache-2.0
//
// T = f((l - l0) / l0) + d (l' - l0'), f piecewise linear; see the docstring of this package. `numbers`: strains and
// tensions, N, of the points, 0 for unused points at the end; damping d, N s/m.
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

struct Tabulated {
    static constexpr int POINTS = 5, STRAIN = 0, TENSION = 5, DAMPING = 10;

    // Piece of the curve between two points, or beyond the last one; the first begins at 0.
    template <class T> struct Piece {
        T strain, tension, slope;  // at its beginning; slope in N
    };
    template <class T> static CDPR_INLINE Piece<T> piece(const T* numbers, int k) {
        const T strain = k > 0 ? numbers[STRAIN + k - 1] : T(0.0), tension = k > 0 ? numbers[TENSION + k - 1] : T(0.0);
        return {strain, tension, (numbers[TENSION + k] - tension) / (numbers[STRAIN + k] - strain)};
    }
    template <class T> static CDPR_INLINE Truth<T> used(const T* numbers, int k) {
        return numbers[STRAIN + k] > T(0.0);
    }

    // Return the tension, N, at rest with a strain.
    template <class T> static CDPR_INLINE T tension_at(const T* numbers, T strain) {
        T found = piece(numbers, 0).slope * strain;
        for (int k = 1; k < POINTS; k++) {
            const Piece<T> at = piece(numbers, k);
            found =
                select(used(numbers, k) & (strain > at.strain), at.tension + at.slope * (strain - at.strain), found);
        }
        return found;
    }

    // Return the tension, N, as of the elastic cable.
    template <class T> static CDPR_INLINE T pull(const T* numbers, T length, T unwound, T stretching, T lowest) {
        const T stretch = length - unwound;
        const T tension = tension_at(numbers, stretch / unwound) + numbers[DAMPING] * stretching;
        const Truth<T> slack = (stretch <= T(0.0)) & (lowest == T(0.0));
        return select(slack, T(0.0), select(tension < lowest, lowest, tension));
    }

    // Return the unwound length, m, of a cable at rest with this tension, N.
    template <class T> static CDPR_INLINE T rest(const T* numbers, T length, T tension) {
        T strain = tension / piece(numbers, 0).slope;
        for (int k = 1; k < POINTS; k++) {
            const Piece<T> at = piece(numbers, k);
            const Truth<T> beyond = used(numbers, k) & (tension > at.tension);
            strain = select(beyond, at.strain + (tension - at.tension) / at.slope, strain);
        }
        return length / (1.0 + strain);
    }

    // Return the energy, J, per unwound length, m, of a strain.
    static inline double energy(const double* numbers, double strain) {
        double total = 0.0;
        for (int k = 0; k < POINTS && (k == 0 || used(numbers, k)); k++) {
            const Piece<double> at = piece(numbers, k);
            const bool last = k + 1 == POINTS || !used(numbers, k + 1);
            const double end = last || strain < numbers[STRAIN + k] ? strain : numbers[STRAIN + k];
            const double part = end - at.strain;
            if (k > 0 && !(part > 0.0)) break;
            total += part * (at.tension + 0.5 * at.slope * part);
        }
        return total;
    }
};

}  // namespace cdpr::CDPR_TARGET
