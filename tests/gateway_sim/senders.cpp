#include "senders.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "judge/message.hpp"
#include "project_text.hpp"
#include "takt/publish/output_slot.hpp"

namespace takt::gatewaysim {

using namespace std::chrono_literals;

namespace {

constexpr std::uint32_t kFirstValue = 1'000'000;
constexpr std::size_t kRememberedCommands = 8;

}  // namespace

Senders::Senders(const Scenario& scenario, Publish publish)
    : scenario_(scenario), publish_(std::move(publish)), random_(sim::Random(scenario.seed).fork(0xC0)) {
    const auto& configuration = *scenario.configuration;
    const auto& project = configuration.project();
    const auto& output = project.outputs.at(0);
    has_commands_ = !output.commandable.empty();
    for (const auto& line : project.lines)
        for (const auto& device : line.devices) {
            if (device.poll_enable) devices_.push_back(device.name);
            for (const auto& variable : device.variables) {
                const bool hidden = variable.name.ends_with("hidden") || !has_commands_;
                if (variable.write) (hidden ? hidden_ : writable_).push_back(variable.name);
                if (!variable.write) readable_.push_back(variable.name);
            }
        }
    (has_commands_ ? locals_ : hidden_).emplace_back(kMode);
    hidden_.emplace_back(kSecret);
    const auto mean = scenario.means.command;
    next_ = mean > Duration{} ? scenario.begin + random_.between(1s, 2 * mean + 1s) : kNever;
}

const std::string& Senders::one_of(const std::vector<std::string>& names) {
    return names[random_.below(static_cast<std::uint32_t>(names.size()))];
}

void Senders::act(Instant now, std::int64_t wall_ns) {
    const bool burst = now < scenario_.quiet_from && chance(1);
    for (auto left = burst ? 20 + random_.below(280) : 1; left > 0; --left) send(wall_ns);
    next_ = now + random_.between(1ms, 2 * scenario_.means.command);
}

void Senders::send(std::int64_t wall_ns) {
    if (!last_.empty() && chance(5))
        return publish_(last_[random_.below(static_cast<std::uint32_t>(last_.size()))]);
    auto command = make(wall_ns);
    if (scenario_.retained_commands && chance(3)) command.message.retain = true;
    last_.push_back(command);
    if (last_.size() > kRememberedCommands) last_.pop_front();
    publish_(command);
}

SentCommand Senders::make(std::int64_t wall_ns) {
    SentCommand command;
    command.id = "c" + std::to_string(++count_);
    command.message.topic = std::string(kControlTopic) + "/command";
    const auto kind = random_.below(100);
    if (kind < 4) {
        command.well_formed = command.executable = false;
        command.message.payload =
            chance(50) ? "{\"id\": " : R"({"id":")" + command.id + R"(","command":"set"})";
        if (command.message.payload.size() < 10) command.id.clear();
        return command;
    }
    add_subject(command);
    if (kind < 8) {
        // A plain value.
        command.message.topic = std::string(kControlTopic) + "/set/" + command.subject;
        command.message.payload = std::to_string(*command.value);
        command.id.clear();
        return command;
    }
    if (kind < 12 && !last_.empty() && !last_.front().id.empty()) command.id = last_.front().id;
    add_expiry(command, wall_ns);
    compose(command, chance(50) ? "set" : "write");
    return command;
}

void Senders::add_subject(SentCommand& command) {
    command.value = kFirstValue + count_;
    const bool listed = has_commands_ && !chance(10);
    command.executable = listed;
    if (!listed)
        command.subject = chance(70) ? one_of(hidden_) : "Nowhere";
    else
        command.subject = chance(80) ? one_of(writable_) : one_of(locals_);
}

void Senders::add_expiry(SentCommand& command, std::int64_t wall_ns) {
    const auto seconds = [](std::int64_t count) { return count * 1'000'000'000; };
    wall_ns -= wall_ns % 1'000'000;  // as it is written
    const auto kind = random_.below(10);
    const auto age = chance(20) ? seconds(60 + random_.below(4000)) : seconds(random_.below(3));
    if (kind < 4 || kind == 9) command.expiry = Duration(seconds(1 + random_.below(20)));
    if (kind >= 3 && kind < 6) command.sent_ns = wall_ns - age;
    if (kind == 6) command.expires_ns = wall_ns + seconds(10) - age;
    if (kind == 7) command.message.properties.expiry_s = 1 + random_.below(15);
    if (kind == 9 && chance(30)) command.sent_ns = wall_ns + seconds(200);
}

void Senders::compose(SentCommand& command, const std::string& verb) {
    std::string text = R"({"id":")" + command.id + "\"";
    const auto add = [&](const std::string& key, const std::string& value) {
        text += ",\"" + key + "\":" + value;
    };
    const auto kind = random_.below(20);
    const bool other = kind < 3 && command.executable;
    if (other) command.value.reset();
    if (other && kind == 0) {
        command.subject = one_of(readable_);
        add("command", "\"get\"");
    } else if (other && kind == 1) {
        command.subject = kGo;
        add("command", "\"trigger\"");
    } else if (other) {
        command.subject = devices_.empty() ? "D1" : one_of(devices_);
        command.executable = !devices_.empty();
        add("command", chance(60) ? "\"enable\"" : "\"disable\"");
    } else {
        add("command", "\"" + verb + "\"");
        add("value", std::to_string(*command.value));
    }
    add(other && kind == 2 ? "device" : "variable", "\"" + command.subject + "\"");
    if (command.sent_ns) add("sent", "\"" + time_text(*command.sent_ns) + "\"");
    if (command.expires_ns) add("expires", "\"" + time_text(*command.expires_ns) + "\"");
    if (command.expiry) add("expiry_s", std::to_string(command.expiry->count() / 1'000'000'000));
    command.message.payload = text + "}";
    if (!chance(60)) return;
    command.message.properties.response_topic = "reply/" + std::to_string(random_.below(3));
    command.message.properties.correlation_data = command.id;
}

}  // namespace takt::gatewaysim
