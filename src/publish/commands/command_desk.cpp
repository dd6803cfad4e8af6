#include "takt/publish/command_desk.hpp"

#include <algorithm>
#include <deque>
#include <map>
#include <utility>

#include "commands/command_memory.hpp"
#include "mqtt/mqtt_packet.hpp"
#include "takt/base/assert.hpp"
#include "takt/base/utf8.hpp"

namespace takt::publish {

/// Where the answer goes.
struct ReplyAddress {
    std::string topic;
    std::string correlation_data;
};

enum class CommandState : std::uint8_t { waiting, submitted };

struct OpenCommand {
    CommandRequest request;
    CommandOrigin origin;
    ReplyAddress reply;
    host::ConfigurationPtr configuration;  // of the slot in `command`
    host::Command command;
    CommandState state = CommandState::waiting;
};

namespace {

constexpr std::size_t kLongestTopic = 512;  // in the audit log

struct Expiry {
    Instant at;
    bool future = false;  // the sender's clock is ahead
};

Expiry expiry_of(const CommandTime& now, const CommandRequest& request, const MqttProperties& properties,
                 Duration standard) {
    const auto at = [&](std::int64_t wall_ns) { return after(now.t, Duration(wall_ns - now.wall_ns)); };
    const Duration length = request.expiry.value_or(standard);
    Instant end = after(now.t, CommandRequest::kLongestExpiry);
    if (request.expires_ns) end = std::min(end, at(*request.expires_ns));
    if (request.sent_ns) end = std::min(end, after(at(*request.sent_ns), length));
    if (properties.expiry_s) end = std::min(end, after(now.t, std::chrono::seconds(*properties.expiry_s)));
    if (request.expiry || (!request.expires_ns && !request.sent_ns && !properties.expiry_s))
        end = std::min(end, after(now.t, length));
    return {end, request.sent_ns && at(*request.sent_ns) > after(now.t, CommandDesk::kFuture)};
}

std::size_t reply_bytes(const MqttProperties& properties) {
    return properties.response_topic.size() + properties.correlation_data.size();
}

std::size_t bytes_of(const LiveMessage& live) {
    return live.message.topic.size() + live.message.payload.size() + live.short_payload.size() +
           live.message.properties.correlation_data.size();
}

std::uint64_t content_of(const MqttMessage& message) {
    return std::hash<std::string>()(message.payload);
}

}  // namespace

struct CommandDesk::State {
    CommandDeskOptions options;
    CommandRights rights;
    CommandMemory memory;
    std::map<std::uint64_t, OpenCommand> open;  // by tag: in the order of arrival
    std::uint64_t last_tag = 0;
    std::uint64_t last_id = 0;
    std::deque<LiveMessage> answers;
    std::size_t answer_bytes = 0;
    CommandCounters counters;
    std::uint64_t missing_lines = 0;  // of the audit log, since the last one
    bool stopped = false;

    std::optional<ParsedCommand> parse(const MqttMessage& message);
    ReplyAddress reply_of(const MqttProperties& properties) const;
    std::optional<CommandRefused> first_check(const MqttInbound& inbound, const ParsedCommand& parsed) const;
    std::expected<host::Command, CommandRefused> accept(const CommandTime& now, const CommandRequest& request,
                                                        const MqttProperties& properties) const;
    bool is_repeated(const CommandRequest& request, std::uint64_t content, const ReplyAddress& reply,
                     std::optional<CommandRefused>& refused);
    void answer(const ReplyAddress& reply, const CommandAnswer& answer);
    void remove_first_answer();
    void audit(const CommandOrigin& origin, const CommandAnswer& answer);
    void end(std::map<std::uint64_t, OpenCommand>::iterator command, CommandAnswer&& with);
};

std::optional<ParsedCommand> CommandDesk::State::parse(const MqttMessage& message) {
    std::string_view topic = message.topic;
    if (!topic.starts_with(options.control_topic)) return std::nullopt;
    topic.remove_prefix(options.control_topic.size());
    constexpr std::string_view kSet = "/set/";
    if (topic == "/command") return parse_command(message.payload);
    if (!topic.starts_with(kSet)) return std::nullopt;
    return plain_set(options.id_prefix + std::to_string(++last_id), topic.substr(kSet.size()),
                     message.payload);
}

// An answer to a topic of commands would be a command.
ReplyAddress CommandDesk::State::reply_of(const MqttProperties& properties) const {
    if (reply_bytes(properties) > kLongestReply) return {options.control_topic + "/answer", {}};
    const auto& topic = properties.response_topic;
    const bool own =
        topic == options.control_topic + "/command" || topic.starts_with(options.control_topic + "/set/");
    const bool usable = is_topic_name(topic) && !own;
    return {usable ? topic : options.control_topic + "/answer", properties.correlation_data};
}

std::optional<CommandRefused> CommandDesk::State::first_check(const MqttInbound& inbound,
                                                              const ParsedCommand& parsed) const {
    if (inbound.message.retain) return CommandRefused{CommandRefusal::retained, {}};
    if (!inbound.subscribed) return CommandRefused{CommandRefusal::not_subscribed, {}};
    if (const auto bytes = reply_bytes(inbound.message.properties); bytes > kLongestReply)
        return CommandRefused{.detail = "response topic and correlation data: " + std::to_string(bytes) +
                                        " bytes; allowed: " + std::to_string(kLongestReply)};
    return parsed.refused;
}

std::expected<host::Command, CommandRefused> CommandDesk::State::accept(
    const CommandTime& now, const CommandRequest& request, const MqttProperties& properties) const {
    const auto expiry = expiry_of(now, request, properties, options.expiry);
    if (expiry.future)
        return std::unexpected(
            CommandRefused{CommandRefusal::clock, "sent: more than 60 s after the time of this computer"});
    if (expiry.at <= now.t) return std::unexpected(CommandRefused{CommandRefusal::expired, {}});
    auto command = target_of(request, rights);
    if (!command) return command;
    if (open.size() >= kMostOpen)
        return std::unexpected(
            CommandRefused{CommandRefusal::too_many, std::to_string(kMostOpen) + " have no outcome yet"});
    command->expires = expiry.at;
    return command;
}

bool CommandDesk::State::is_repeated(const CommandRequest& request, std::uint64_t content,
                                     const ReplyAddress& reply, std::optional<CommandRefused>& refused) {
    const auto* const known = memory.find(request.id);
    if (known == nullptr) return false;
    if (known->content != content) {
        refused = CommandRefused{CommandRefusal::duplicate_id, "id: " + request.id};
        return false;
    }
    if (known->answer) answer(reply, *known->answer);
    return true;
}

void CommandDesk::State::answer(const ReplyAddress& reply, const CommandAnswer& with) {
    LiveMessage live{.message = {.topic = reply.topic, .payload = answer_message(with)},
                     .short_payload = short_answer_message(with)};
    live.message.properties.correlation_data = reply.correlation_data;
    live.message.properties.content_type = "application/json";
    answer_bytes += bytes_of(live);
    answers.push_back(std::move(live));
    while (answers.size() > kMostAnswers || answer_bytes > kMostAnswerBytes) {
        remove_first_answer();
        ++counters.answers_dropped;
    }
}

void CommandDesk::State::remove_first_answer() {
    answer_bytes -= bytes_of(answers.front());
    answers.pop_front();
}

void CommandDesk::State::audit(const CommandOrigin& origin, const CommandAnswer& with) {
    if (!options.audit) return;
    std::string lines;
    if (missing_lines > 0) lines = missing_lines_text(origin.output, missing_lines, with.wall_ns);
    if (options.audit(lines + audit_line(origin, with))) {
        missing_lines = 0;
        return;
    }
    ++missing_lines;
    ++counters.unrecorded;
}

void CommandDesk::State::end(std::map<std::uint64_t, OpenCommand>::iterator command, CommandAnswer&& with) {
    answer(command->second.reply, with);
    audit(command->second.origin, with);
    if (auto* const entry = memory.find(with.id)) entry->answer = std::move(with);
    open.erase(command);
}

CommandDesk::CommandDesk(CommandDeskOptions options) : state_(std::make_unique<State>()) {
    TAKT_ASSERT(options.expiry > Duration::zero());
    state_->options = std::move(options);
}

CommandDesk::CommandDesk(CommandDesk&&) noexcept = default;
CommandDesk& CommandDesk::operator=(CommandDesk&&) noexcept = default;
CommandDesk::~CommandDesk() = default;

void CommandDesk::set_rights(CommandRights rights) {
    state_->rights = std::move(rights);
}

bool CommandDesk::on_message(const CommandTime& now, std::string_view broker, const MqttInbound& inbound) {
    State& state = *state_;
    TAKT_ASSERT(state.rights.configuration);
    if (state.stopped) return false;
    auto parsed = state.parse(inbound.message);
    if (!parsed) return false;
    ++state.counters.received;
    auto& request = parsed->request;
    const auto reply = state.reply_of(inbound.message.properties);
    const auto content = content_of(inbound.message);
    auto refused = state.first_check(inbound, *parsed);
    const bool identified = !refused;  // remembered by its id
    if (!refused && state.is_repeated(request, content, reply, refused)) return true;
    const bool duplicate = identified && refused;
    host::Command command;
    if (!refused) {
        if (auto accepted = state.accept(now, request, inbound.message.properties))
            command = *std::move(accepted);
        else
            refused = std::move(accepted).error();
    }
    CommandOrigin origin{state.options.output, std::string(broker),
                         std::string(whole_characters(inbound.message.topic, kLongestTopic))};
    if (refused) {
        ++state.counters.refused;
        auto answer = answer_of(request, *refused, now.wall_ns);
        state.answer(reply, answer);
        state.audit(origin, answer);
        if (identified && !duplicate) state.memory.add(request.id, false, {content, std::move(answer)});
        return true;
    }
    const auto tag = ++state.last_tag;
    command.tag = tag;
    state.memory.add(request.id, true, {content, std::nullopt});
    state.open.emplace(tag, OpenCommand{.request = std::move(request),
                                        .origin = std::move(origin),
                                        .reply = reply,
                                        .configuration = state.rights.configuration,
                                        .command = std::move(command)});
    return true;
}

std::optional<host::Command> CommandDesk::next_command(const CommandTime& now) {
    State& state = *state_;
    while (true) {
        const auto next = std::ranges::find_if(
            state.open, [](const auto& entry) { return entry.second.state == CommandState::waiting; });
        if (next == state.open.end()) return std::nullopt;
        auto& command = next->second;
        const bool replaced = command.configuration != state.rights.configuration;
        if (command.command.expires > now.t && !replaced) {
            command.state = CommandState::submitted;
            return command.command;
        }
        const CommandRefused refused{replaced ? CommandRefusal::unknown_variable : CommandRefusal::expired,
                                     replaced ? "the project was replaced" : ""};
        state.end(next, answer_of(command.request, refused, now.wall_ns));
    }
}

void CommandDesk::on_rejected(const CommandTime& now, std::uint64_t tag, const Error& error) {
    State& state = *state_;
    const auto found = state.open.find(tag);
    if (found == state.open.end()) return;
    const auto& command = found->second.command;
    const host::Outcome outcome{
        .tag = tag, .kind = command.kind, .slot = command.slot, .t = now.t, .error = error};
    on_outcome(now, outcome);
}

void CommandDesk::on_outcome(const CommandTime& now, const host::Outcome& outcome) {
    State& state = *state_;
    const auto found = state.open.find(outcome.tag);
    if (found == state.open.end()) return;
    const auto& command = found->second;
    auto answer = answer_of(command.request, outcome, *command.configuration, now.wall_ns);
    // A host that stops, or gets another project, ends what it has not sent.
    if (answer.end == CommandEnd::expired && outcome.t < command.command.expires) {
        answer.end = CommandEnd::refused;
        answer.reason = "stopped";
    }
    state.end(found, std::move(answer));
}

void CommandDesk::stop(const CommandTime& now) {
    State& state = *state_;
    state.stopped = true;
    while (!state.open.empty()) {
        const auto first = state.open.begin();
        const auto& command = first->second;
        host::Outcome outcome{.kind = command.command.kind,
                              .slot = command.command.slot,
                              .t = now.t,
                              .result = command.state == CommandState::submitted
                                            ? value::CommandResult::unknown
                                            : value::CommandResult::refused};
        outcome.value = command.command.value;
        auto answer = answer_of(command.request, outcome, *command.configuration, now.wall_ns);
        answer.reason = "stopped";
        state.end(first, std::move(answer));
    }
}

const LiveMessage* CommandDesk::first_answer() const {
    return state_->answers.empty() ? nullptr : &state_->answers.front();
}

void CommandDesk::remove_first_answer() {
    state_->remove_first_answer();
}

std::size_t CommandDesk::open() const {
    return state_->open.size();
}

CommandCounters CommandDesk::counters() const {
    return state_->counters;
}

}  // namespace takt::publish
