// Operations on many enclosures. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/analysis/workspace/enclosure.hpp>
#include <cdpr/field.hpp>

namespace cdpr::CDPR_TARGET {

// Sums, products, multiples and largest absolute values of k pairs of models c, x, y, z, r (enclosure.hpp).
struct ModelArithmetic {
    const double* first;   // (k, 5)
    const double* second;  // (k, 5)
    const double* factor;  // (k)
    double* sum;           // (k, 5), first + second
    double* product;       // (k, 5), first second
    double* multiple;      // (k, 5), factor first
    double* largest;       // (k), of the first
    int64_t k;
    static constexpr char fields[] =
        "first(k, 5), second(k, 5), factor(k), sum(k, 5), product(k, 5), multiple(k, 5), largest(k), k";
};

inline int model_arithmetic(ModelArithmetic& pairs) {
    for (int64_t i = 0; i < pairs.k; i++) {
        const Model a = model(pairs.first + 5 * i), b = model(pairs.second + 5 * i);
        store(a + b, pairs.sum + 5 * i);
        store(a * b, pairs.product + 5 * i);
        store(pairs.factor[i] * a, pairs.multiple + 5 * i);
        pairs.largest[i] = a.largest();
    }
    return 0;
}

// Models of 1 / |v - d| in boxes with half sides h.
struct InverseDistances {
    const double* vector;  // (k, 3), v, m
    const double* half;    // (k, 3), h, m
    const double* error;   // (k), m, of each entry of v
    double* model;         // (k, 5), r infinite if the distance may be 0
    int64_t k;
    static constexpr char fields[] = "vector(k, 3), half(k, 3), error(k), model(k, 5), k";
};

inline int inverse_distances(InverseDistances& boxes) {
    for (int64_t i = 0; i < boxes.k; i++)
        store(inverse_distance(vector(boxes.vector + 3 * i), vector(boxes.half + 3 * i), boxes.error[i]),
              boxes.model + 5 * i);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
