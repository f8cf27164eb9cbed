// Stand-ins for the parts of rclcpp that a generated node uses. A run of the node is a replay: `spin` reads states (13
// doubles each) from the file in the environment variable STATES, publishes each as pose and twist, fires the timer,
// and writes the published positions, velocities and efforts to the file in COMMANDS. If the node subscribes to winches,
// they publish the unwound lengths in the file UNWOUND (one for each of the names in CABLES, in a row) before the timer.
#pragma once
#include <stdio.h>
#include <stdlib.h>

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace ament_index_cpp {
inline std::string get_package_share_directory(const std::string&) { return getenv("SHARE"); }
}  // namespace ament_index_cpp

namespace rclcpp {

struct Time {
    double at;
    double seconds() const { return at; }
};

}  // namespace rclcpp

struct Vector {
    double x, y, z;
};
struct Quaternion {
    double x, y, z, w;
};
struct Header {
    rclcpp::Time stamp;
    std::string frame_id;
};
struct Pose {
    Vector position;
    Quaternion orientation;
};
struct Twist {
    Vector linear, angular;
};

namespace geometry_msgs::msg {
struct PoseStamped {
    Header header;
    Pose pose;
};
struct TwistStamped {
    Header header;
    Twist twist;
};
}  // namespace geometry_msgs::msg

namespace sensor_msgs::msg {
struct JointState {
    Header header;
    std::vector<std::string> name;
    std::vector<double> position, velocity, effort;
};
}  // namespace sensor_msgs::msg

namespace std_srvs::srv {
struct Trigger {
    struct Request {};
    struct Response {
        bool success = false;
        std::string message;
    };
};
}  // namespace std_srvs::srv

namespace rclcpp {

template <class M> struct Publisher {
    using SharedPtr = std::shared_ptr<Publisher>;
    std::vector<M> sent;
    void publish(const M& message) { sent.push_back(message); }
};
template <class M> struct Subscription {
    using SharedPtr = std::shared_ptr<Subscription>;
    std::function<void(const M&)> call;
};
template <class S> struct Service {
    using SharedPtr = std::shared_ptr<Service>;
    std::function<void(std::shared_ptr<typename S::Request>, std::shared_ptr<typename S::Response>)> call;
};
struct TimerBase {
    using SharedPtr = std::shared_ptr<TimerBase>;
    double period;
    std::function<void()> call;
};
struct Logger {};

class Node {
  public:
    explicit Node(const std::string& name) : name(name) {}
    template <class T> T declare_parameter(const std::string&, const T& value) { return value; }
    template <class M> typename Publisher<M>::SharedPtr create_publisher(const std::string&, int) {
        return commands = std::make_shared<Publisher<M>>();
    }
    template <class M, class F>
    typename Subscription<M>::SharedPtr create_subscription(const std::string&, int, F call) {
        auto made = std::make_shared<Subscription<M>>(Subscription<M>{call});
        remember(made);
        return made;
    }
    template <class S, class F> typename Service<S>::SharedPtr create_service(const std::string&, F call) {
        return start = std::make_shared<Service<S>>(Service<S>{call});
    }
    template <class F> TimerBase::SharedPtr create_wall_timer(std::chrono::duration<double> period, F call) {
        return timer = std::make_shared<TimerBase>(TimerBase{period.count(), call});
    }
    Time now() const { return {clock}; }
    Logger get_logger() const { return {}; }

    void remember(std::shared_ptr<Subscription<geometry_msgs::msg::PoseStamped>> made) { poses = made; }
    void remember(std::shared_ptr<Subscription<geometry_msgs::msg::TwistStamped>> made) { twists = made; }

    void remember(std::shared_ptr<Subscription<sensor_msgs::msg::JointState>> made) { winches = made; }

    std::string name;
    double clock = 1000.0;
    std::shared_ptr<Publisher<sensor_msgs::msg::JointState>> commands;
    std::shared_ptr<Subscription<geometry_msgs::msg::PoseStamped>> poses;
    std::shared_ptr<Subscription<geometry_msgs::msg::TwistStamped>> twists;
    std::shared_ptr<Subscription<sensor_msgs::msg::JointState>> winches;
    std::shared_ptr<Service<std_srvs::srv::Trigger>> start;
    TimerBase::SharedPtr timer;
};

inline void init(int, char**) {}
inline void shutdown() {}

inline void spin(std::shared_ptr<Node> node) {
    node->timer->call();  // no state yet: nothing may be published
    FILE* states = fopen(getenv("STATES"), "rb");
    auto response = std::make_shared<std_srvs::srv::Trigger::Response>();
    node->start->call(std::make_shared<std_srvs::srv::Trigger::Request>(), response);
    sensor_msgs::msg::JointState unwound;
    FILE* lengths = node->winches ? fopen(getenv("UNWOUND"), "rb") : nullptr;
    std::istringstream cables(lengths ? getenv("CABLES") : "");
    for (std::string name; cables >> name;) unwound.name.push_back(name);
    unwound.position.resize(unwound.name.size());
    double s[13];
    while (fread(s, sizeof s, 1, states) == 1) {
        node->clock += node->timer->period;
        node->poses->call({{}, {{s[0], s[1], s[2]}, {s[4], s[5], s[6], s[3]}}});
        node->twists->call({{}, {{s[7], s[8], s[9]}, {s[10], s[11], s[12]}}});
        if (lengths && fread(unwound.position.data(), sizeof(double), unwound.position.size(), lengths))
            node->winches->call(unwound);
        node->timer->call();
    }
    fclose(states);
    if (lengths) fclose(lengths);
    node->clock += 60.0;
    node->timer->call();  // an old state: likewise
    FILE* commands = fopen(getenv("COMMANDS"), "wb");
    for (const auto& message : node->commands->sent) {
        for (const auto* field : {&message.position, &message.velocity, &message.effort})
            fwrite(field->data(), sizeof(double), field->size(), commands);
        for (const auto& cable : message.name) printf("%s ", cable.c_str());
        printf("\n");
    }
    fclose(commands);
}

}  // namespace rclcpp

#define RCLCPP_WARN(logger, ...) ((void)(logger), fprintf(stderr, __VA_ARGS__), fprintf(stderr, "\n"))
