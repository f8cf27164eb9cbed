// MuJoCo's step and clock, called by their C addresses. SPDX-License-Identifier: Apache-2.0
//
// See the docstring of the module. No header of MuJoCo is needed: `words` contains the addresses of its functions.
#pragma once

#include <cdpr/field.hpp>

namespace cdpr::CDPR_TARGET {

// Callback of MuJoCo, with the model and data of its batch, which do not change.
typedef void MujocoCallback(void* model, void* data, int number, void* words);

struct MujocoWords {
    static constexpr int APPLY = 0, BATCH = 1, STEP = 2, GET_STATE = 3, MODEL = 4, DATA = 5;

    const int64_t* words;

    template <class Function> CDPR_INLINE Function* function(int place) const {
        return reinterpret_cast<Function*>(words[place]);
    }
    CDPR_INLINE void* address(int place) const { return reinterpret_cast<void*>(words[place]); }
};

struct MujocoStep {
    const int64_t* words;  // (6): addresses of mjb_apply, the batch, mj_step, mj_getState, our model and data
    static constexpr char fields[] = "words(6)";
};

inline void mujoco_step_alone(void*, void*, int, void* place) {
    const MujocoWords mujoco = {static_cast<const int64_t*>(place)};
    mujoco.function<void(void*, void*)>(MujocoWords::STEP)(mujoco.address(MujocoWords::MODEL),
                                                           mujoco.address(MujocoWords::DATA));
}

// Return 0, or 1 if MuJoCo failed.
inline int mujoco_step(MujocoStep& problem) {
    typedef int Apply(void* batch, const int* which, int count, MujocoCallback* callback, void* words, int threads);
    const MujocoWords mujoco = {problem.words};
    return mujoco.function<Apply>(MujocoWords::APPLY)(mujoco.address(MujocoWords::BATCH), nullptr, 0, mujoco_step_alone,
                                                      const_cast<int64_t*>(problem.words), 0);
}

struct MujocoClock {
    const int64_t* words;  // (6), as of MujocoStep
    double* clock;         // (1), s
    int64_t time;          // mjSTATE_TIME
    static constexpr char fields[] = "words(6), clock(1), time";
};

inline int mujoco_clock(MujocoClock& problem) {
    typedef void GetState(const void* model, const void* data, double* state, int what);
    const MujocoWords mujoco = {problem.words};
    mujoco.function<GetState>(MujocoWords::GET_STATE)(mujoco.address(MujocoWords::MODEL),
                                                      mujoco.address(MujocoWords::DATA), problem.clock,
                                                      static_cast<int>(problem.time));
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
