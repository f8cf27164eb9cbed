// Image-based visual servoing on markers: cdpr_controllers/visual_servo.py. SPDX-License-Identifier: Apache-2.0
//
// Interaction matrix of points: Chaumette and Hutchinson, Visual Servo Control, Part I: Basic Approaches, IEEE Robotics
// and Automation Magazine 13 (2006), eq. 11. Filter of fading memory of the third order: Brookner, Tracking and Kalman
// Filtering Made Easy (1998), section 1.3.
#pragma once

#include <cdpr/cholesky.hpp>
#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/mechanics/proportional_derivative.hpp>
#include <cdpr/sensing/markers.hpp>

namespace cdpr::CDPR_TARGET {

// Further steps at the first image, from which the matrix at the estimated pose follows: from 0.5 m and 0.6 rad, it
// differs afterwards by less than noise of the image.
constexpr int FIRST_IMAGE_STEPS = 4;

// Numbers of `VisualServo::clock`.
enum ServoClock { STEPS, IMAGES, SINCE_IMAGE, LAST_AGE, PIXEL_ERROR, MARKERS_SEEN, SERVO_CLOCK };

struct VisualServo {
    const double* gains;     // (12): kp (6), 1/s^2, and kd (6), 1/s, of x, y, z, rx, ry, rz
    const double* inertial;  // (13), `Robot.inertial`
    const double* gravity;   // (3), m/s^2, world
    const double* desired;   // (19): position, m; quaternion; velocities; accelerations; world axes
    const double* camera;    // (7), as of Markers
    const double* markers;   // (k, 3), as of Markers
    const double* lens;      // (6), as of Markers
    const double* pixels;    // (k, 2), px, measured
    const double* seen;      // (k), 1 if a marker is seen, else 0
    const double* age;       // (1), s, of the measurement
    const int64_t* rows;     // (n), degrees of freedom
    const double* scale;     // (n): 1 for translations and the characteristic length, m, for rotations
    double* error;           // (6), m and rad, estimate of the desired pose minus the actual one, world axes
    double* rate;            // (6), m/s and rad/s, likewise
    double* offset;          // (6), m/s^2 and rad/s^2, estimate of what acts besides the feedback
    double* feedback;        // (6), m/s^2 and rad/s^2, of the previous step
    double* clock;          // (6), by ServoClock: calls; images used; s, since the last of them; s, age in the previous
                            // call; px, root mean square error in the last image; markers in it
    double* servo_error;    // (1), px, for the log, as are the following
    double* servo_markers;  // (1)
    double* servo_age;      // (1), s
    double* wrench;         // (6), N and N m, about the platform's origin
    double* normal_matrix;  // (n, n), work space
    double* gradient;       // (n), work space
    double step;            // s, control period
    double smoothing;       // s, time constant of the filter
    double share;           // share of the matrix at the desired pose in the interaction matrix, 0 to 1
    int64_t carried;        // as of Markers
    int64_t k;
    int64_t n;
    static constexpr char fields[] =
        "gains(12), inertial(13), gravity(3), desired(19), camera(7), markers(k, 3), lens(6), pixels(k, 2), seen(k), "
        "age(1), rows(n), scale(n), both error(6), both rate(6), both offset(6), both feedback(6), both clock(6), "
        "servo_error(1), "
        "servo_markers(1), servo_age(1), wrench(6), work normal_matrix(n, n), work gradient(n), step, smoothing, "
        "share, "
        "carried, k, n";
};

// A marker before the camera: normalised image coordinates, and what the rows of the interaction matrix need.
struct MarkerView {
    double x, y, depth;         // x / z and y / z; z, m
    Vector<double> lever;       // m, from the platform's origin, world axes
    Quaternion<double> camera;  // attitude of the camera
};

CDPR_INLINE MarkerView view_marker(const VisualServo& p, Placement platform, int64_t i) {
    const Placement mount = {vector(p.camera), quaternion(p.camera + 3)};
    const Vector<double> own = vector(p.markers + 3 * i);
    const Vector<double> place = p.carried ? own : platform.outwards(own);
    const Vector<double> x = mount.inwards(p.carried ? platform.inwards(place) : place);
    const Quaternion<double> camera = p.carried ? multiply(platform.attitude, mount.attitude) : mount.attitude;
    return {x.x / x.z, x.y / x.z, x.z, place - platform.place, camera};
}

// Entry `axis` of a row of the interaction matrix: change of the image coordinate `along` (0: x, 1: y) at (x, y) per
// velocity of the platform. The camera moves relative to the markers; it is the opposite if it is on the platform.
CDPR_INLINE double interaction(const VisualServo& p, const MarkerView& view, int along, double x, double y,
                               int64_t axis) {
    const Vector<double> own = {along == 0 ? 1.0 : 0.0, along == 0 ? 0.0 : 1.0, along == 0 ? -x : -y};
    const Vector<double> force = rotate(view.camera, (p.carried ? -1.0 : 1.0) / view.depth * own);
    const Vector<double> entry = axis < 3 ? force : cross(view.lever, force);
    return axis % 3 == 0 ? entry.x : axis % 3 == 1 ? entry.y : entry.z;
}

// Desired pose `delay` (s) before, moved back along the desired motion, and the pose that lies `error` (6) before it.
CDPR_INLINE Placement earlier(const double* desired, double delay) {
    const double half = 0.5 * delay * delay;
    const Vector<double> travel = delay * vector(desired + 7) - half * vector(desired + 13);
    const Vector<double> turn = delay * vector(desired + 10) - half * vector(desired + 16);
    return {vector(desired) - travel, multiply(exponential(-1.0 * turn), quaternion(desired + 3))};
}
CDPR_INLINE Placement displaced(Placement wanted, const double* error) {
    return {wanted.place - vector(error), multiply(exponential(-1.0 * vector(error + 3)), wanted.attitude)};
}

// Add the two rows of marker i to the normal equations; return its squared error, px^2.
inline double add_marker(VisualServo& p, Placement wanted, Placement actual, int64_t i) {
    const Matrix<double> normal = {p.normal_matrix, p.n};
    const double* const focal = p.lens;
    const double x = (p.pixels[2 * i] - p.lens[2]) / focal[0], y = (p.pixels[2 * i + 1] - p.lens[3]) / focal[1];
    const MarkerView goal = view_marker(p, wanted, i), here = view_marker(p, actual, i);
    const double missing[] = {goal.x - x, goal.y - y};
    for (int along = 0; along < 2; along++) {
        double row[6];
        for (int64_t j = 0; j < p.n; j++) {
            const double then = interaction(p, goal, along, goal.x, goal.y, p.rows[j]);
            const double now = interaction(p, here, along, x, y, p.rows[j]);
            row[j] = (p.share * then + (1.0 - p.share) * now) / p.scale[j];
        }
        for (int64_t j = 0; j < p.n; j++) {
            p.gradient[j] += row[j] * missing[along];
            for (int64_t l = 0; l <= j; l++) normal(j, l) += row[j] * row[l];
        }
    }
    const double u = focal[0] * missing[0], v = focal[1] * missing[1];
    return u * u + v * v;
}

// Write the displacement (6) from the actual to the desired pose in an image taken `age` (s) ago, when it was about
// `before` (6). Return false if the markers in the image do not determine it.
inline bool displacement(VisualServo& p, double age, const double* before, double* found) {
    for (int64_t j = 0; j < p.n; j++) {
        p.gradient[j] = 0.0;
        for (int64_t l = 0; l < p.n; l++) p.normal_matrix[j * p.n + l] = 0.0;
    }
    const Placement wanted = earlier(p.desired, age), actual = displaced(wanted, before);
    double squares = 0.0, count = 0.0;
    bool ahead = true;
    for (int64_t i = 0; i < p.k; i++) {
        if (p.seen[i] == 0.0) continue;
        ahead = ahead && !(view_marker(p, wanted, i).depth <= 0.0 || view_marker(p, actual, i).depth <= 0.0);
        squares += add_marker(p, wanted, actual, i);
        count += 1.0;
    }
    p.clock[MARKERS_SEEN] = count;
    if (count == 0.0) return false;
    p.clock[PIXEL_ERROR] = square_root(squares / count);
    for (int j = 0; j < 6; j++) found[j] = 0.0;
    if (squares != squares) {  // not a number shows in the wrench
        for (int j = 0; j < 6; j++) found[j] = squares;
        return true;
    }
    const Matrix<double> normal = {p.normal_matrix, p.n};
    if (!ahead || 2.0 * count < double(p.n) || !factorise(normal, p.n, 0.0)) return false;
    solve(normal, p.gradient, p.gradient, p.n);
    for (int64_t j = 0; j < p.n; j++) found[p.rows[j]] = p.gradient[j] / p.scale[j];
    return true;
}

// Estimate of the error `delay` (s) before, entry j.
CDPR_INLINE double before(const VisualServo& p, double delay, int j) {
    return p.error[j] - delay * p.rate[j] + 0.5 * delay * delay * (p.offset[j] - p.feedback[j]);
}

// Correct the estimate by an image that was taken `age` (s) ago and shows a displacement (6).
inline void correct(VisualServo& p, double age, const double* found) {
    const bool alone = !(p.clock[IMAGES] > 0.0);
    const double elapsed = p.clock[SINCE_IMAGE] - age;  // s, from the image before
    const double memory = alone ? 0.0 : exponential(-elapsed / p.smoothing), lost = 1.0 - memory;
    const double weight = 1.0 - memory * memory * memory;
    const double rate_weight = alone ? 0.0 : 1.5 * lost * lost * (1.0 + memory) / elapsed;  // 1/s
    const double offset_weight = alone ? 0.0 : lost * lost * lost / (elapsed * elapsed);    // 1/s^2
    for (int j = 0; j < 6; j++) {
        const double innovation = found[j] - before(p, age, j);
        const double faster = rate_weight * innovation, stronger = offset_weight * innovation;
        p.error[j] += weight * innovation + age * (faster + 0.5 * age * stronger);
        p.rate[j] += faster + age * stronger;
        p.offset[j] += stronger;
    }
    p.clock[IMAGES] += 1.0;
    p.clock[SINCE_IMAGE] = age;
}

// Advance the estimate by a control step, with the feedback that acted, and correct it by an image that has arrived.
inline void estimate(VisualServo& p) {
    const double h = p.step, age = *p.age;
    const bool first = p.clock[STEPS] == 0.0;
    for (int j = 0; !first && j < 6; j++) {
        const double a = p.offset[j] - p.feedback[j];
        p.error[j] += h * p.rate[j] + 0.5 * h * h * a;
        p.rate[j] += h * a;
    }
    const bool arrived = first || age < p.clock[LAST_AGE] + 0.5 * h;
    if (!first) p.clock[SINCE_IMAGE] += h;
    p.clock[STEPS] += 1.0;
    p.clock[LAST_AGE] = age;
    if (!arrived) return;
    double near[6], found[6];
    for (int j = 0; j < 6; j++) near[j] = before(p, age, j);
    if (!displacement(p, age, near, found)) return;
    for (int i = 0; p.clock[IMAGES] == 0.0 && i < FIRST_IMAGE_STEPS; i++) {
        for (int j = 0; j < 6; j++) near[j] = found[j];
        if (!displacement(p, age, near, found)) return;
    }
    correct(p, age, found);
}

inline int visual_servo(VisualServo& p) {
    estimate(p);
    for (int j = 0; j < 6; j++) p.feedback[j] = p.gains[j] * p.error[j] + p.gains[6 + j] * p.rate[j];
    const Placement actual = displaced({vector(p.desired), quaternion(p.desired + 3)}, p.error);
    const Vector<double> omega = vector(p.desired + 10) - vector(p.rate + 3);
    const Vector<double> a = vector(p.desired + 13) + vector(p.feedback);
    const Vector<double> alpha = vector(p.desired + 16) + vector(p.feedback + 3);
    store(inverse_dynamics<double>({p.inertial}, vector(p.gravity), actual.attitude, omega, a, alpha), p.wrench);
    *p.servo_error = p.clock[PIXEL_ERROR];
    *p.servo_markers = p.clock[MARKERS_SEEN];
    *p.servo_age = p.clock[SINCE_IMAGE];
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
