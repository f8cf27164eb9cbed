// Spring and damper between the platform and its desired motion, plus compensation of the weight.

struct place {
    const double *force;   // (3), N, force that balances the weight
    const double *center;  // (3), m, center of mass, platform axes
    const double *gains;   // (4), N/m and N s/m, N m/rad and N m s/rad
    const double *state;   // (13), position, quaternion w x y z, velocity, angular velocity
    const double *desired; // (19), the same, then acceleration and angular acceleration
    double *wrench;        // (6), N and N m
};

static void cross(const double *a, const double *b, double *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

int spring(const struct place *p, double time) {
    const double *q = p->state + 3, *d = p->desired + 3, *gains = p->gains;
    double turned[3], twice[3], lever[3], moment[3], part[3];
    cross(q + 1, p->center, turned);
    cross(q + 1, turned, twice);
    for (int i = 0; i < 3; i++) lever[i] = p->center[i] + 2.0 * (q[0] * turned[i] + twice[i]);
    cross(lever, p->force, moment);
    cross(d + 1, q + 1, part);
    const double same = d[0] * q[0] + d[1] * q[1] + d[2] * q[2] + d[3] * q[3];
    const double side = same < 0.0 ? -2.0 : 2.0;
    for (int i = 0; i < 3; i++) {
        const double angle = side * (q[0] * d[1 + i] - d[0] * q[1 + i] - part[i]);
        const double move = p->desired[i] - p->state[i], speed = p->desired[7 + i] - p->state[7 + i];
        const double spin = p->desired[10 + i] - p->state[10 + i];
        p->wrench[i] = p->force[i] + gains[0] * move + gains[1] * speed;
        p->wrench[3 + i] = moment[i] + gains[2] * angle + gains[3] * spin;
    }
    (void)time;
    return 0;
}
