#include "takt/publish/project_outputs.hpp"

#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <type_traits>
#include <utility>

#include "mqtt/file_reason.hpp"
#include "mqtt/mosquitto_pipe.hpp"
#include "outputs/history_work.hpp"
#include "outputs/unusable_work.hpp"
#include "takt/file/read.hpp"
#include "takt/model/output.hpp"
#include "takt/model/output_remedies.hpp"
#include "takt/os/rotating_file.hpp"
#include "takt/publish/command_desk.hpp"
#include "takt/publish/mqtt_composer.hpp"
#include "takt/publish/mqtt_work.hpp"
#include "takt/publish/output_slot.hpp"

namespace takt::publish {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(const std::string& project_file) {
    return fs::absolute(project_file).parent_path();
}

/// Relative to the project's file; empty stays empty.
std::string path_of(const std::string& project_file, const std::string& path) {
    return path.empty() ? std::string() : (folder_of(project_file) / path).string();
}

std::string first_line(std::string_view text) {
    std::string line(text.substr(0, text.find('\n')));
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return line;
}

/// @returns the reason why there is none
std::expected<std::string, std::string> password_of(const model::MqttSettings& settings,
                                                    const std::string& project_file) {
    if (!settings.password_file.empty()) {
        const auto path = path_of(project_file, settings.password_file);
        const auto text = file::read_file(path, file::kMaxSecretBytes);
        if (!text)
            return std::unexpected("password_file " + settings.password_file + ": " +
                                   file_reason(text.error()));
        return first_line(*text);
    }
    if (settings.password_env.empty()) return std::string();
    const char* const value = std::getenv(settings.password_env.c_str());
    if (value == nullptr) return std::unexpected("password_env " + settings.password_env + ": not set");
    return std::string(value);
}

std::uint64_t fnv1a(std::string_view text, std::uint64_t hash = 0xcbf29ce484222325U) {
    for (const char byte : text) hash = (hash ^ static_cast<std::uint8_t>(byte)) * 0x100000001b3U;
    return hash;
}

std::string machine_id() {
    const auto text = file::read_file("/etc/machine-id", file::kMaxSecretBytes);
    return text ? first_line(*text) : std::string();
}

// The same after a restart, and another one for each machine, project and output: brokers end the older of
// two connections with the same client identifier.
std::string default_client_id(const model::Output& output, const std::string& project_file) {
    std::array<char, 256> host{};
    (void)::gethostname(host.data(), host.size() - 1);
    const auto hash = fnv1a(fs::absolute(project_file).string(), fnv1a(machine_id(), fnv1a(host.data())));
    std::array<char, 20> text{};
    (void)std::snprintf(text.data(), text.size(), "%08x", static_cast<unsigned>(hash ^ (hash >> 32U)));
    return "takt-" + output.name + "-" + text.data();
}

MqttVersions versions_of(model::MqttVersionChoice choice) {
    switch (choice) {
        case model::MqttVersionChoice::automatic: return MqttVersions::automatic;
        case model::MqttVersionChoice::v5: return MqttVersions::only_5;
        case model::MqttVersionChoice::v3_1_1: return MqttVersions::only_3_1_1;
    }
    return MqttVersions::automatic;
}

MqttMessage state_topic(const MqttComposer& composer, bool online) {
    MqttMessage message{.topic = composer.control_topic("state"), .payload = state_message(online)};
    message.retain = true;
    message.properties.content_type = "application/json";
    return message;
}

MqttSessionOptions session_options(const model::Output& output, const MqttComposer& composer,
                                   const std::string& project_file, const std::string& password) {
    const auto& settings = output.mqtt;
    MqttSessionOptions options;
    for (const auto& broker : settings.brokers) {
        MqttBroker one{.host = broker.host, .port = broker.port, .tls = {}};
        if (broker.tls)
            one.tls = MqttTls{.ca_file = path_of(project_file, settings.ca_file),
                              .certificate_file = path_of(project_file, settings.certificate_file),
                              .key_file = path_of(project_file, settings.key_file),
                              .alpn = settings.alpn};
        options.brokers.push_back(std::move(one));
    }
    options.versions = versions_of(settings.version);
    options.client_id =
        settings.client_id.empty() ? default_client_id(output, project_file) : settings.client_id;
    options.user = settings.user;
    options.password = password;
    options.keep_alive = std::chrono::duration_cast<std::chrono::seconds>(settings.keep_alive);
    options.first_pause = settings.backoff.first;
    options.longest_pause = settings.backoff.limit;
    options.longest_nearby_pause = settings.nearby_limit;
    options.window = settings.in_flight;
    options.birth = state_topic(composer, true);
    options.will = state_topic(composer, false);
    options.seed = fnv1a(options.client_id);
    return options;
}

/// Writes to commands.log beside the journal. A file that cannot be opened is tried again with each line.
std::function<bool(std::string_view)> audit_of(const ProjectOutputsOptions& options,
                                               const model::Output& output) {
    return [folder = journal_folder(options.project_file, output),
            file = std::shared_ptr<os::RotatingFile>()](std::string_view lines) mutable {
        if (!file) {
            std::error_code ignored;
            fs::create_directories(folder, ignored);
            auto opened = os::RotatingFile::open(folder + "/commands.log", {});
            if (!opened) return false;
            file = *std::move(opened);
        }
        return file->write(lines).error == 0;
    };
}

CommandRights rights_in(const host::ConfigurationPtr& configuration, const std::string& name) {
    for (const auto& output : configuration->project().outputs)
        if (output.name == name) return rights_of(configuration, output);
    return {.configuration = configuration, .commandable = {}, .readable = {}};
}

void add_commands(const ProjectOutputsOptions& options, const model::Output& output,
                  MqttWork::Options& work) {
    if (output.commandable.empty()) return;
    const auto& topic = output.mqtt.control_topic;
    work.session.subscriptions = {{.filter = topic + "/command"}, {.filter = topic + "/set/#"}};
    const auto start = std::chrono::system_clock::now().time_since_epoch();
    CommandDeskOptions desk{.output = output.name,
                            .control_topic = topic,
                            .expiry = output.command_expiry,
                            .id_prefix = output.name + "-" + std::to_string(start.count()) + "-",
                            .audit = audit_of(options, output)};
    work.commands.emplace(
        MqttWork::Commands{.desk = CommandDesk(std::move(desk)),
                           .rights = [name = output.name](const host::ConfigurationPtr& configuration) {
                               return rights_in(configuration, name);
                           }});
}

std::unique_ptr<OutputWork> mqtt_work(const ProjectOutputsOptions& options, const model::Output& output,
                                      const host::Configuration& configuration) {
    const auto unusable = [&](std::string reason) {
        return std::make_unique<UnusableWork>(model::url_of(output.mqtt.brokers.front()), std::move(reason));
    };
    const auto password = password_of(output.mqtt, options.project_file);
    if (!password) return unusable(password.error());
    auto session = options.open_session({.events = false});
    if (!session) return unusable(std::string(name(session.error().code)));
    auto composer = std::make_unique<MqttComposer>(output, configuration);
    MqttWork::Options work;
    work.session = session_options(output, *composer, options.project_file, *password);
    work.status_topic = composer->control_topic("status");
    work.composer = std::move(composer);
    work.pipe = std::make_unique<MosquittoPipe>();
    work.host = *std::move(session);
    work.remedies = model::output_remedies(output);
    add_commands(options, output, work);
    return std::make_unique<MqttWork>(std::move(work));
}

std::unique_ptr<OutputWork> history_work(const ProjectOutputsOptions& options, const model::Output& output) {
    store::HistoryOptions history;
    history.retention = output.journal.retention;
    history.quota_bytes = output.journal.quota;
    return std::make_unique<HistoryWork>(history_database(options.project_file),
                                         journal_folder(options.project_file, output), history);
}

SamplePolicy policy_of(const model::OutputSelection& selection) {
    const auto& policy = selection.policy;
    return {.on_change = policy.on_change,
            .period = policy.period,
            .heartbeat = policy.heartbeat,
            .dead_band = policy.dead_band,
            .skip_bad = policy.skip_bad,
            .retained = selection.retain};
}

// A history keeps its values itself.
store::JournalOptions journal_options(const model::Output& output) {
    const auto& settings = output.journal;
    store::JournalOptions options;
    if (output.transport == model::OutputTransport::history) {
        options.retention = std::chrono::hours(1);
        return options;
    }
    options.buffer_bytes = static_cast<std::size_t>(settings.buffer / 2);  // the other half: SampleQueue
    options.quota_bytes = settings.quota;
    options.retention = settings.retention;
    return options;
}

/// Another one where there is another password, or the reason why there is none.
std::uint64_t password_mark(const model::MqttSettings& settings, const std::string& project_file) {
    const auto password = password_of(settings, project_file);
    return password ? fnv1a(*password) : fnv1a(password.error(), 1);
}

/// All that the thread and the work of an output depend on: equal texts, equal work.
std::string settings_text(const model::Output& output, const host::Configuration& configuration,
                          const std::string& project_file) {
    std::string text;
    const auto add = [&](const auto& part) {
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(part)>>)
            text += std::to_string(part) + '\n';
        else
            text += std::string(part) + '\n';
    };
    const auto& mqtt = output.mqtt;
    for (const auto& broker : mqtt.brokers) add(model::url_of(broker));
    for (const auto& part :
         {mqtt.client_id, mqtt.user, mqtt.password_file, mqtt.password_env, mqtt.ca_file,
          mqtt.certificate_file, mqtt.key_file, mqtt.alpn, mqtt.control_topic, output.journal.directory})
        add(part);
    add(password_mark(mqtt, project_file));
    add(static_cast<int>(output.transport));
    add(static_cast<int>(mqtt.version));
    add(mqtt.keep_alive.count());
    add(mqtt.in_flight);
    add(mqtt.backoff.first.count());
    add(mqtt.backoff.limit.count());
    add(mqtt.nearby_limit.count());
    add(static_cast<int>(mqtt.backlog));
    add(output.journal.quota);
    add(output.journal.retention.count());
    add(output.journal.buffer);
    add(output.command_expiry.count());
    for (const auto& value : output.values) {
        const auto& selection = output.selections.at(value.selection);
        add(configuration.info(slot_of(configuration.slots(), value.subject)).name);
        add(value.topic);
        add(static_cast<int>(selection.message));
        add(selection.retain ? 1 : 0);
    }
    // Which variables are commandable is read anew with each configuration (CommandRights).
    add(output.commandable.empty() ? 0 : 1);
    return text;
}

}  // namespace

std::string journal_folder(const std::string& project_file, const model::Output& output) {
    const auto& directory = output.journal.directory;
    const auto base =
        directory.empty() ? model::journal_directory(fs::path(project_file).filename().string()) : directory;
    return (folder_of(project_file) / base / output.name).string();
}

std::string history_database(const std::string& project_file) {
    return (folder_of(project_file) / fs::path(project_file).filename())
        .replace_extension(".history.db")
        .string();
}

/// The end of the program lasts at most a second, also with a broker that does not answer.
constexpr Duration kStopLimit = std::chrono::milliseconds(700);

std::vector<OutputSetup> project_outputs(const ProjectOutputsOptions& options,
                                         const host::ConfigurationPtr& configuration) {
    std::vector<OutputSetup> setups;
    for (const auto& output : configuration->project().outputs) {
        OutputSetup setup;
        setup.settings = settings_text(output, *configuration, options.project_file);
        setup.thread = {.name = output.name,
                        .directory = journal_folder(options.project_file, output),
                        .journal = journal_options(output),
                        .queue_bytes = static_cast<std::size_t>(output.journal.buffer / 2),
                        .stop_limit = kStopLimit,
                        .log = options.log ? options.log("publish") : Log()};
        for (const auto& value : output.values)
            setup.selected.push_back({slot_of(configuration->slots(), value.subject),
                                      policy_of(output.selections.at(value.selection))});
        setup.make_work = [options, configuration, &output] {
            return output.transport == model::OutputTransport::history
                       ? history_work(options, output)
                       : mqtt_work(options, output, *configuration);
        };
        setups.push_back(std::move(setup));
    }
    return setups;
}

}  // namespace takt::publish
