// Potential energy of a platform on cables, and unstretched lengths of cables at rest. SPDX-License-Identifier:
// Apache-2.0
//
// A cable is a span with a fixed unwound length, or it pulls with max(lowest, force + penalty (length - unwound)): a
// constant tension for a penalty of 0, otherwise the augmented Lagrangian of a cable that does not stretch (Hestenes,
// J. Optim. Theory Appl. 4, 1969). A span that bends has its own constant tension; the energy of a sagging cable on a
// pulley is approximate (rates.hpp), its force is not.
#pragma once

#include <cdpr/cables/chain.hpp>
#include <cdpr/mechanics/sag.hpp>

namespace cdpr::CDPR_TARGET {

struct Potential {
    // Step of the derivatives of tensions, as a share of the length: one-sided towards taut cables, of second order.
    static constexpr double SHARE = 1e-5;

    const double* lines;     // (m, w), as in Geometry
    const double* chains;    // (m, 33), as in ChainRow
    const double* inertial;  // (13), `Robot.inertial`
    const double* gravity;   // (3), m/s^2, world
    const double* pose;      // (7): position, m, and quaternion
    const int64_t* spring;   // (m), 0: as above; 1: the span with its unwound length; 2: that bends, with its tension
    const double* unwound;   // (m), m
    const double* force;     // (m), N
    const double* penalty;   // (m), N/m
    double* energy;          // (1), J
    double* gradient;        // (6), J/m and J: for motions of the origin and rotation vectors, world axes
    double* hessian;         // (6, 6), symmetric
    double* matrix;          // (6, m), wrench matrix
    double* length;          // (m), m
    double* tension;         // (m), N
    double* slope;           // (m), N/m, of the tension with the length
    double* shift;           // (m), N/m, of the tension with the unwound length
    double* response;        // (6, m), rate of the wrench with the unwound length, or without it with the tension
    double* state;           // (13), work space
    double* rates;           // (6, 6, m), work space
    double* spare;           // (m), work space
    int64_t m;
    int64_t w;
    static constexpr char fields[] =
        "lines(m, w >= 6), chains(m, 33), inertial(13), gravity(3), pose(7), spring(m), unwound(m), force(m), "
        "penalty(m), energy(1), gradient(6), hessian(6, 6), matrix(6, m), length(m), tension(m), slope(m), shift(m), "
        "response(6, m), "
        "work state(13), work rates(6, 6, m), work spare(m), m, w";
};

// Return the derivative of f at x for steps h of second order to one side.
template <class F> CDPR_INLINE double one_sided(F f, double x, double h) {
    return (4.0 * f(x + h) - 3.0 * f(x) - f(x + 2.0 * h)) / (2.0 * h);
}

// Write tension and derivatives of a span at rest; return its energy, J: four points of Gauss and Legendre.
inline double load_span(const Potential& at, int64_t i) {
    static constexpr double POINTS[] = {0.06943184420297371, 0.33000947820757187, 0.6699905217924281,
                                        0.9305681557970262},
                            WEIGHTS[] = {0.17392742256872692, 0.32607257743127307, 0.32607257743127307,
                                         0.17392742256872692};
    const ChainRow<double> row = chain_row(at.chains, i);
    const double l = at.length[i], l0 = at.unwound[i], lowest = row.lowest(), stretch = l - l0;
    const auto of_length = [&](double x) { return pull(row.span_kind(), row.span(), x, l0, 0.0, lowest); };
    const auto of_unwound = [&](double x) { return pull(row.span_kind(), row.span(), l, x, 0.0, lowest); };
    const double t = of_length(l);
    const bool slack = t <= lowest;
    at.tension[i] = t;
    at.slope[i] = slack ? 0.0 : one_sided(of_length, l, Potential::SHARE * l0);
    at.shift[i] = slack ? 0.0 : one_sided(of_unwound, l0, -Potential::SHARE * l0);
    const double known = strain_energy(row.span_kind(), row.span(), l, l0);
    if (known == known) return slack ? 0.0 : known;
    double total = 0.0;
    for (int j = 0; j < 4; j++) total += WEIGHTS[j] * of_length(l0 + POINTS[j] * stretch);
    return slack ? 0.0 : total * stretch;
}

// The same of a cable with a constant tension or a penalty.
inline double load_other(const Potential& at, int64_t i) {
    const double lowest = chain_row(at.chains, i).lowest(), k = at.penalty[i];
    const double wanted = at.force[i] + (k > 0.0 ? k * (at.length[i] - at.unwound[i]) : 0.0);
    const bool slack = k > 0.0 && wanted <= lowest;
    const double t = slack ? lowest : wanted;
    at.tension[i] = t;
    at.slope[i] = slack ? 0.0 : k;
    at.shift[i] = -at.slope[i];
    return k > 0.0 ? 0.5 * t * t / k : t * at.length[i];
}

// Return whether cable i is a span that bends, with its length or tension.
inline bool sags(const Potential& at, int64_t i) { return at.spring[i] && bends(chain_row(at.chains, i).span_kind()); }

// Write tension and rates of a cable that sags; add its wrench to `pull` and its stiffness to K; return its energy, J.
inline double load_sagging(const Potential& at, int64_t i, Wrench<double>& pull, double* K) {
    const ChainRow<double> row = chain_row(at.chains, i);
    const Line<double> cable = line(at.lines, at.w, i, vector(at.pose), quaternion(at.pose + 3));
    const BentSpan<double> span = cable.span(cable.lead(), row.span(), vector(at.gravity));
    const bool given = at.spring[i] == 1;
    const double unwound = given ? at.unwound[i] : bent_rest(row.span_kind(), span, at.force[i]);
    SaggingCable sagging(cable, row, vector(at.gravity), unwound);
    at.shift[i] = sagging.tension_rates[SaggingCable::LENGTH];
    if (!given) sagging.keep_tension();
    at.tension[i] = sagging.tension, at.slope[i] = given ? -at.shift[i] : 0.0;
    store(sagging.rates[SaggingCable::LENGTH].force, sagging.rates[SaggingCable::LENGTH].moment, at.response + i, at.m);
    pull = pull + sagging.wrench;
    sagging.add_stiffness(K);
    return bent_energy(row.span_kind(), span, unwound, !given);
}

inline int potential(Potential& at) {
    if (!has_anchors<double>(at.w)) return BAD_INPUT;
    const int64_t m = at.m;
    Stiffness held = {};
    held.lines = at.lines, held.inertial = at.inertial, held.gravity = at.gravity, held.state = at.state;
    held.rates = at.rates, held.length = at.length, held.spare = at.spare, held.m = m, held.w = at.w;
    write_geometry(held, at.pose, at.matrix);
    const Inertial<double> body = {at.inertial};
    const Vector<double> arm = body.lever(quaternion(at.pose + 3)), weight = body.mass() * vector(at.gravity);
    double total = -dot(weight, vector(at.pose) + arm), K[36], bent[36] = {};
    Wrench<double> known = {weight, cross(arm, weight)};
    double* const t = at.spare;  // of the cables that pull along their chords
    const double* W = at.matrix;
    for (int64_t i = 0; i < m; i++) {
        if (sags(at, i)) {
            total += load_sagging(at, i, known, bent);
            t[i] = 0.0;
            continue;
        }
        total += at.spring[i] ? load_span(at, i) : load_other(at, i);
        t[i] = at.tension[i];
        const double change = at.spring[i] || at.penalty[i] > 0.0 ? at.shift[i] : 1.0;
        for (int j = 0; j < 6; j++) at.response[j * m + i] = change * W[j * m + i];
    }
    at.energy[0] = total;
    store(known, at.gradient);
    for (int i = 0; i < 6; i++) {
        at.gradient[i] = -sum(at.gradient[i], 0, m, [&](int64_t c) { return W[i * m + c] * t[c]; });
        for (int j = 0; j < 6; j++) {
            const double* rate = at.rates + (6 * j + i) * m;
            K[6 * i + j] = sum(bent[6 * i + j], 0, m, [&](int64_t c) {
                const double slope = sags(at, c) ? 0.0 : at.slope[c];
                return W[i * m + c] * W[j * m + c] * slope - rate[c] * t[c];
            });
        }
    }
    add_weight(held, at.pose, K);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) at.hessian[6 * i + j] = 0.5 * (K[6 * i + j] + K[6 * j + i]);
    return 0;
}

// Unwound lengths of cables at rest with given tensions at their winches; of cables that do not stretch, their lengths.
struct RestLengths {
    TensionedCables cables;
    double* unwound;  // (k, m), m
    static constexpr auto fields = extended(TensionedCables::fields, "unwound(k, m)");
};

inline int rest_lengths(RestLengths& held) {
    const TensionedCables& cables = held.cables;
    if (!cables.valid()) return BAD_INPUT;
    for (int64_t k = 0; k < cables.k; k++) {
        for (int64_t i = 0; i < cables.m; i++) {
            const Line<double> cable = cables.cable(k, i);
            const ExitResult<double> exit = cable.lead();
            const double whole = length(cable.chord(exit.point)) + exit.wrapped_length;
            const ChainRow<double> row = cables.row(i);
            const BentSpan<double> ends = cable.span(exit, row.span(), cables.down());
            const int64_t place = k * cables.m + i;
            held.unwound[place] = row.stretches() ? unwound_length(row, ends, whole, cables.tension[place]) : whole;
        }
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
