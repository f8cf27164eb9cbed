/* Gazebo's physics library with its engine DART, without Gazebo: a world of SDF in which a link is pushed.
 *
 * Called with the engine's file, a world, a model, a link, how many steps, and a force and a moment, world axes, N and
 * N m, as gz-sim's system ApplyLinkWrench passes them on in each step. Prints the link's place, m, and its quaternion.
 */
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <string>

#include <ignition/physics/ForwardStep.hh>
#include <ignition/physics/FrameSemantics.hh>
#include <ignition/physics/GetEntities.hh>
#include <ignition/physics/Link.hh>
#include <ignition/physics/RequestEngine.hh>
#include <ignition/physics/sdf/ConstructWorld.hh>
#include <ignition/plugin/Loader.hh>
#include <sdf/Root.hh>
#include <sdf/World.hh>

namespace physics = ignition::physics;

struct Needed : physics::FeatureList<physics::ForwardStep, physics::GetEntities, physics::LinkFrameSemantics,
                                     physics::AddLinkExternalForceTorque, physics::sdf::ConstructSdfWorld> {};

static int fail(const std::string &why) {
    std::cerr << why << "\n";
    return 1;
}

int main(int count, char **words) {
    if (count != 12) return fail("ENGINE WORLD MODEL LINK STEPS FX FY FZ MX MY MZ");
    ignition::plugin::Loader loader;
    ignition::plugin::PluginPtr plugin;
    loader.LoadLib(words[1]);
    for (const auto &name : loader.AllPlugins())
        if (name.find("dartsim") != std::string::npos) plugin = loader.Instantiate(name);
    auto engine = physics::RequestEngine3d<Needed>::From(plugin);
    if (!engine) return fail("no engine");
    sdf::Root root;
    for (const auto &error : root.Load(words[2])) return fail(error.Message());
    auto world = engine->ConstructWorld(*root.WorldByIndex(0));
    auto model = world ? world->GetModel(std::string(words[3])) : nullptr;
    auto link = model ? model->GetLink(std::string(words[4])) : nullptr;
    if (!link) return fail("no such link");
    Eigen::Matrix<double, 6, 1> wrench;
    for (int k = 0; k < 6; k++) wrench[k] = std::atof(words[6 + k]);
    physics::ForwardStep::Input input;
    physics::ForwardStep::State state;
    physics::ForwardStep::Output output;
    for (int k = std::atoi(words[5]); k > 0; k--) {
        link->AddExternalForce(wrench.head<3>());
        link->AddExternalTorque(wrench.tail<3>());
        world->Step(output, state, input);
    }
    const auto pose = link->FrameDataRelativeToWorld().pose;
    const Eigen::Quaterniond q(pose.linear());
    std::cout << std::setprecision(17) << pose.translation().transpose() << " " << q.w() << " " << q.vec().transpose();
}
