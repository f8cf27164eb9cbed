// Cables that sag at a pose of the platform, and their stiffness. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/mechanics/stiffness.hpp>

namespace cdpr::CDPR_TARGET {

// Cable at rest with a given unwound length: its wrench about the platform's origin, N and N m, world axes, with rates
// for unit velocities of the platform and of the unwound length.
struct SaggingCable {
    static constexpr int LENGTH = 6, MOTIONS = 7;  // six directions of a twist, then the unwound length

    Wrench<double> wrench, rates[MOTIONS];
    double tension, tension_rates[MOTIONS];  // N, at the winch

    inline SaggingCable(const Line<double>& cable, const ChainRow<double>& row, Vector<double> gravity,
                        double unwound) {
        const ExitResult<double> exit = cable.lead();
        const BentSpan<double> span = cable.span(exit, row.span(), gravity);
        const BentCable<double> end = bent_pull(row.span_kind(), span, unwound, 0.0, row.lowest());
        const Vector<double> none = {0.0, 0.0, 0.0}, u = (1.0 / length(span.chord)) * span.chord;
        Vector<double> turning[MOTIONS];  // rates of the lever
        BentMotion motions[MOTIONS];
        BentCable<double> changes[MOTIONS];
        for (int j = 0; j < 6; j++) {
            double unit[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
            unit[j] = 1.0;
            turning[j] = cross(vector(unit + 3), cable.lever);
            const Vector<double> tip = vector(unit) + turning[j], leaving = cable.velocity_of_exit(tip);
            motions[j] = {leaving - tip, -dot(u, leaving), -1.0 * leaving, 0.0};
        }
        turning[LENGTH] = none, motions[LENGTH] = {none, 0.0, none, 1.0};
        bent_rates(row.span_kind(), span, unwound, motions, MOTIONS, changes);
        wrench = {end.force, cross(cable.lever, end.force)}, tension = end.tension;
        for (int j = 0; j < MOTIONS; j++) {
            const Vector<double> f = changes[j].force;
            rates[j] = {f, cross(turning[j], end.force) + cross(cable.lever, f)};
            tension_rates[j] = changes[j].tension;
        }
    }

    // Make the rates those at constant tension at the winch: the last ones then are per N of that tension.
    inline void keep_tension() {
        const double per = 1.0 / tension_rates[LENGTH];
        rates[LENGTH] = {per * rates[LENGTH].force, per * rates[LENGTH].moment};
        for (int j = 0; j < LENGTH; j++) {
            const double share = -tension_rates[j];
            rates[j] = rates[j] + Wrench<double>{share * rates[LENGTH].force, share * rates[LENGTH].moment};
        }
    }

    // Add the stiffness to K (6, 6), row by row.
    inline void add_stiffness(double* K) const {
        for (int j = 0; j < 6; j++) {
            double rate[6];
            store(rates[j], rate);
            for (int i = 0; i < 6; i++) K[6 * i + j] -= rate[i];
        }
    }
};

// Cables at poses of the platform, with tensions at their winches.
struct TensionedCables {
    const double* lines;    // (m, w), as in Geometry
    const double* chains;   // (m, 33), as in ChainRow
    const double* gravity;  // (3), m/s^2, world
    const double* poses;    // (k, 7): position, m, and quaternion
    const double* tension;  // (k, m), N
    int64_t k;
    int64_t m;
    int64_t w;
    static constexpr char fields[] = "lines(m, w >= 6), chains(m, 33), gravity(3), poses(k, 7), tension(k, m), k, m, w";

    bool valid() const { return has_anchors<double>(w); }
    Vector<double> down() const { return vector(gravity); }
    ChainRow<double> row(int64_t i) const { return chain_row(chains, i); }
    Line<double> cable(int64_t at, int64_t i) const {
        return line(lines, w, i, vector(poses + 7 * at), quaternion(poses + 7 * at + 3));
    }
};

// Addition of the cables that sag to the stiffness with locked drums; they are taut. `stiffness` contains the other
// cables.
struct SaggingStiffness {
    TensionedCables cables;
    double* stiffness;  // (k, 6, 6), N/m, N, N m
    static constexpr auto fields = extended(TensionedCables::fields, "both stiffness(k, 6, 6)");
};

inline int sagging_stiffness(SaggingStiffness& held) {
    const TensionedCables& cables = held.cables;
    if (!cables.valid()) return BAD_INPUT;
    for (int64_t k = 0; k < cables.k; k++) {
        for (int64_t i = 0; i < cables.m; i++) {
            const ChainRow<double> row = cables.row(i);
            if (!bends(row.span_kind())) continue;
            const Line<double> cable = cables.cable(k, i);
            const BentSpan<double> span = cable.span(cable.lead(), row.span(), cables.down());
            const double unwound = bent_rest(row.span_kind(), span, cables.tension[k * cables.m + i]);
            SaggingCable(cable, row, cables.down(), unwound).add_stiffness(held.stiffness + 36 * k);
        }
    }
    return 0;
}

// Wrench of cables that sag minus that of their tensions along their chords, about the platform's origin; they are
// taut.
struct SaggingWrench {
    TensionedCables cables;
    double* wrench;  // (k, 6), N and N m, world axes
    static constexpr auto fields = extended(TensionedCables::fields, "wrench(k, 6)");
};

inline int sagging_wrench(SaggingWrench& held) {
    const TensionedCables& cables = held.cables;
    if (!cables.valid()) return BAD_INPUT;
    const Vector<double> none = {0.0, 0.0, 0.0};
    for (int64_t k = 0; k < cables.k; k++) {
        Wrench<double> total = {none, none};
        for (int64_t i = 0; i < cables.m; i++) {
            const ChainRow<double> row = cables.row(i);
            if (!bends(row.span_kind())) continue;
            const Line<double> cable = cables.cable(k, i);
            const BentSpan<double> span = cable.span(cable.lead(), row.span(), cables.down());
            const double tension = cables.tension[k * cables.m + i];
            const double unwound = bent_rest(row.span_kind(), span, tension);
            const Vector<double> force = bent_pull(row.span_kind(), span, unwound, 0.0, row.lowest()).force;
            const Vector<double> f = force - (tension / length(span.chord)) * span.chord;
            total = total + Wrench<double>{f, cross(cable.lever, f)};
        }
        store(total, held.wrench + 6 * k);
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
