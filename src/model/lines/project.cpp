#include "takt/model/project.hpp"

#include <array>

#include "takt/model/fields.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kOwenFrameBuffer = 256;
constexpr std::size_t kOwenItems = 125;

template <class E>
std::string_view word_of(std::span<const std::string_view> words, E value) {
    const auto index = static_cast<std::size_t>(value);
    return index < words.size() ? words[index] : "unknown";
}

}  // namespace

std::uint16_t Variable::start() const {
    if (!is_bit_area(area)) return register_number;
    return static_cast<std::uint16_t>(register_number * 16 + bit.value_or(0));
}

wire::FrameLimits limits_of(Profile profile) {
    if (profile == Profile::owen_kc1) return {.frame_buffer = kOwenFrameBuffer, .max_items = kOwenItems};
    return {};
}

wire::FrameLimits Project::frame_limits() const {
    return limits_of(profile);
}

DeviceDefaults device_defaults(Profile profile) {
    using namespace std::chrono_literals;
    if (profile == Profile::owen_kc1) return {100ms, 100ms, false, Strategy::classic};
    return {1s, 500ms, true, Strategy::optimal};
}

std::string_view name(Profile profile) {
    return word_of(kProfiles, profile);
}
std::string_view name(Transport transport) {
    return word_of(kTransports, transport);
}
std::string_view name(Strategy strategy) {
    return word_of(kStrategies, strategy);
}

}  // namespace takt::model
