// The values of an output: every value is judged by every selection, so that a pattern that fits nothing is
// known; the first selection that fits has the value.
#include <algorithm>
#include <array>
#include <map>
#include <ranges>
#include <set>
#include <utility>

#include "servers/interpretation.hpp"
#include "servers/output_parts.hpp"
#include "takt/model/name_filter.hpp"
#include "takt/model/nearest.hpp"
#include "takt/model/service.hpp"

namespace takt::model {
namespace {

constexpr std::int64_t kLongestPattern = 200;
constexpr TopicPart kAllParts[] = {TopicPart::output, TopicPart::line, TopicPart::device,
                                   TopicPart::variable};
constexpr std::string_view kMqttSelectionKeys[] = {"topic", "message", "retain"};
constexpr std::string_view kFilterKeys[] = {"variables", "devices", "tags"};
constexpr std::string_view kDefaultTopics[] = {"takt/{output}/{device}/{variable}", "takt/{output}/{device}",
                                               "takt/{output}/{device}"};

/// A value that outputs may have.
struct Candidate {
    OutputSubject subject;
    std::string_view name;
    std::string_view line = kLocalsInTopics;
    std::string_view device = kLocalsInTopics;
    const Variable* variable = nullptr;  ///< nullptr: a local
    bool service = false;                ///< only its exact name selects it
    bool number = true;
};

bool is_numeric(DataType type) {
    return type != DataType::boolean && type != DataType::string;
}

/// Locals, then used variables, in the order of the project.
std::vector<Candidate> candidates(const Project& project) {
    std::vector<Candidate> all;
    for (LocalIndex i = 0; i < project.locals.size(); ++i) {
        const auto& local = project.locals[i];
        if (!local.name.empty())
            all.push_back({.subject = i,
                           .name = local.name,
                           .service = local.service,
                           .number = is_numeric(local.type)});
    }
    for (std::size_t l = 0; l < project.lines.size(); ++l)
        for (std::size_t d = 0; d < project.lines[l].devices.size(); ++d) {
            const auto& device = project.lines[l].devices[d];
            for (std::size_t v = 0; v < device.variables.size(); ++v) {
                const auto& variable = device.variables[v];
                if (variable.used && !variable.name.empty())
                    all.push_back({.subject = PolledIndex{l, d, v},
                                   .name = variable.name,
                                   .line = project.lines[l].name,
                                   .device = device.name,
                                   .variable = &variable,
                                   .number = is_numeric(variable.type)});
            }
        }
    return all;
}

/// The patterns behind a key, with their places.
class PatternList {
public:
    PatternList(Interpretation& state, Reader& reader, std::string_view key) : key_(key) {
        const Node* const list = reader.list(key);
        given_ = reader.given(key);
        if (list == nullptr) return;
        if (list->items.empty()) reader.report(Rule::field_empty, key, {}, {{"key", std::string(key)}});
        std::set<std::string_view> seen;
        for (std::size_t i = 0; i < list->items.size(); ++i) {
            const auto& item = list->items[i];
            auto path = reader.path_of(key) + "[" + std::to_string(i) + "]";
            const auto length = static_cast<std::int64_t>(item.text.size());
            if (item.kind != Node::Kind::scalar) {
                state.findings.add(Rule::field_not_a_value, item.location, path, {});
            } else if (length < 1 || length > kLongestPattern) {
                state.findings.add(Rule::field_length, item.location, path, item.text,
                                   "1.." + std::to_string(kLongestPattern),
                                   {{"length", std::to_string(length)}});
            } else if (!seen.insert(item.text).second) {
                state.findings.add(Rule::output_pattern_twice, item.location, path, item.text);
            } else {
                filter_.add(item.text);
                places_.emplace_back(item.location, std::move(path));
            }
        }
    }

    [[nodiscard]] bool given() const { return given_; }
    [[nodiscard]] std::size_t size() const { return filter_.size(); }
    [[nodiscard]] const std::string& pattern(std::size_t i) const { return filter_.pattern(i); }
    [[nodiscard]] bool used(std::size_t i) const { return filter_.used(i); }
    bool select(std::string_view name) { return filter_.select(name); }
    bool select_exactly(std::string_view name) { return filter_.select_exactly(name); }

    void report(Interpretation& state, Rule rule, std::size_t i, Arguments arguments = {}) const {
        state.findings.add(rule, places_[i].first, places_[i].second, filter_.pattern(i), {},
                           std::move(arguments));
    }

    /// Reports the patterns that fitted nothing.
    /// @param names   that there are
    /// @param unused  names of variables with `used: false`
    void report_unused(Interpretation& state, const std::vector<std::string_view>& names,
                       const std::vector<std::string_view>& unused) const {
        const std::string kind(key_.substr(0, key_.size() - 1));  // "variables" without its s
        for (std::size_t i = 0; i < size(); ++i) {
            if (used(i)) continue;
            if (is_wildcard(pattern(i))) {
                report(state, Rule::output_unmatched, i, {{"kind", kind}});
            } else if (std::ranges::find(unused, pattern(i)) != unused.end()) {
                report(state, Rule::output_unused, i);
            } else if (names.empty()) {
                report(state, Rule::name_none, i, {{"kind", kind}});
            } else if (!resembles_service_name(pattern(i)) || kind != "variable") {  // else reported
                report(state, Rule::output_unknown, i,
                       {{"kind", kind}, {"nearest", std::string(nearest(pattern(i), names))}});
            }
        }
    }

private:
    std::string_view key_;
    bool given_ = false;
    NameFilter filter_;
    std::vector<std::pair<SourceLocation, std::string>> places_;
};

/// `variables`, `devices` and `tags`: a value must fit each one that is given.
class Filter {
public:
    Filter(Interpretation& state, Reader& reader)
        : variables_(state, reader, kFilterKeys[0]),
          devices_(state, reader, kFilterKeys[1]),
          tags_(state, reader, kFilterKeys[2]) {}

    /// Without short cuts, so that each pattern notes its use.
    /// @param locals  whether locals are selected too where no names are given
    bool select(const Candidate& each, bool locals = false) {
        const bool named = !variables_.given() ? locals || each.variable != nullptr
                           : each.service      ? variables_.select_exactly(each.name)
                                               : variables_.select(each.name);
        bool of_device = !devices_.given();
        bool tagged = !tags_.given();
        if (each.variable == nullptr) return named && of_device && tagged;
        if (devices_.given()) {
            const auto qualified = std::string(each.line) + '/' + std::string(each.device);
            of_device = devices_.select(each.device);
            if (devices_.select(qualified)) of_device = true;
        }
        for (const auto& tag : each.variable->tags)
            if (tags_.select(tag)) tagged = true;
        return named && of_device && tagged;
    }

    [[nodiscard]] bool given() const { return variables_.given() || devices_.given() || tags_.given(); }

    void report_unused(Interpretation& state, const std::vector<Candidate>& all) const {
        std::vector<std::string_view> names;
        std::vector<std::string_view> devices;
        std::vector<std::string_view> tags;
        const auto add = [](std::vector<std::string_view>& list, std::string_view name) {
            if (list.size() < kNamesToCompare && std::ranges::find(list, name) == list.end())
                list.push_back(name);
        };
        for (const auto& each : all | std::views::filter([](const Candidate& c) { return !c.service; })) {
            if (names.size() < kNamesToCompare) names.push_back(each.name);
            if (each.variable == nullptr) continue;
            add(devices, each.device);
            for (const auto& tag : each.variable->tags) add(tags, tag);
        }
        variables_.report_unused(state, names, unused_variables(state.project));
        devices_.report_unused(state, devices, {});
        tags_.report_unused(state, tags, {});
    }

    /// Whether the lists are valid and every name without wildcards fits something.
    [[nodiscard]] bool all_found() const {
        return std::ranges::all_of(std::array{&variables_, &devices_, &tags_}, [](const PatternList* list) {
            if (list->given() && list->size() == 0) return false;
            for (std::size_t i = 0; i < list->size(); ++i)
                if (!list->used(i) && !is_wildcard(list->pattern(i))) return false;
            return true;
        });
    }

private:
    static std::vector<std::string_view> unused_variables(const Project& project) {
        std::vector<std::string_view> names;
        for (const auto& line : project.lines)
            for (const auto& device : line.devices)
                for (const auto& variable : device.variables)
                    if (!variable.used) names.push_back(variable.name);
        return names;
    }

    PatternList variables_;
    PatternList devices_;
    PatternList tags_;
};

/// What the keys of an output are for its entries of `select`.
struct Inherited {
    SamplingPolicy policy;
    std::optional<bool> on_change;  ///< as written
    std::optional<TopicTemplate> topic;
    std::optional<MessageScope> message;
    std::optional<bool> retain;
};

/// An entry of `select`, or the output itself.
class SelectionEntry {
public:
    SelectionEntry(Interpretation& state, Reader reader, const Inherited& inherited, bool mqtt)
        : reader_(std::move(reader)), filter_(state, reader_), keys_(inherited) {
        selection_.location = reader_.node().location;
        read_policy();
        if (mqtt)
            read_messages();
        else
            report_keys_without_effect(reader_, kMqttSelectionKeys, name(OutputTransport::history));
    }

    [[nodiscard]] Reader& reader() { return reader_; }
    [[nodiscard]] const Reader& reader() const { return reader_; }
    [[nodiscard]] Filter& filter() { return filter_; }
    [[nodiscard]] const Inherited& keys() const { return keys_; }

    /// What is in force, where the entry has no entries of its own.
    OutputSelection settle(bool mqtt) {
        auto& policy = keys_.policy;
        policy.on_change = keys_.on_change.value_or(policy.period == Duration::zero());
        if (!policy.on_change && policy.period == Duration::zero())
            reader_.report(Rule::output_never, "on_change");
        if (policy.period > Duration::zero() && policy.heartbeat >= policy.period &&
            reader_.given("heartbeat"))
            reader_.report_without_effect("heartbeat", "period: " + to_text(policy.period));
        if (!policy.on_change && reader_.given("dead_band"))
            reader_.report_without_effect("dead_band", "on_change: false");
        selection_.policy = policy;
        if (!mqtt) return selection_;
        selection_.message = keys_.message.value_or(MessageScope::variable);
        const auto scope = static_cast<std::size_t>(selection_.message);
        const bool each = selection_.message == MessageScope::variable;
        selection_.topic = keys_.topic.value_or(*TopicTemplate::parse(kDefaultTopics[scope]));
        selection_.retain = keys_.retain.value_or(each);
        // A message of several values holds those that changed; only by period it holds all.
        if (!each && selection_.retain && policy.on_change)
            reader_.report(Rule::output_retain_partial, "retain", "retain: false",
                           {{"message", std::string(kMessageScopes[scope])}});
        if (!each && selection_.topic.has(TopicPart::variable))
            reader_.report(Rule::topic_variable, "topic", {},
                           {{"message", std::string(kMessageScopes[scope])}});
        return selection_;
    }

    void count(const Candidate& candidate) {
        ++values_;
        numbers_ |= candidate.number;
    }
    [[nodiscard]] std::size_t values() const { return values_; }
    [[nodiscard]] bool numbers() const { return numbers_; }

private:
    void read_policy() {
        auto& policy = keys_.policy;
        if (const auto on_change = reader_.boolean("on_change")) keys_.on_change = on_change;
        policy.period = reader_.duration("period").value_or(policy.period);
        policy.heartbeat = reader_.duration("heartbeat").value_or(policy.heartbeat);
        policy.dead_band = reader_.number("dead_band").value_or(policy.dead_band);
        if (policy.dead_band < 0) {
            reader_.report(Rule::field_out_of_range, "dead_band", ">= 0");
            policy.dead_band = 0;
        }
        policy.skip_bad = reader_.choice<bool>("bad_quality").value_or(policy.skip_bad);
    }

    void read_messages() {
        if (const auto message = reader_.choice<MessageScope>("message")) keys_.message = message;
        if (const auto retain = reader_.boolean("retain")) keys_.retain = retain;
        if (auto topic = read_topic(reader_, "topic", kAllParts)) keys_.topic = *std::move(topic);
    }

    Reader reader_;
    Filter filter_;
    Inherited keys_;
    OutputSelection selection_;
    std::size_t values_ = 0;
    bool numbers_ = false;
};

/// Gives each value its topic, and reports a topic of two.
class Topics {
public:
    Topics(Interpretation& state, Output& output, std::vector<SelectionEntry*> entries)
        : state_(state), output_(output), entries_(std::move(entries)), reported_(entries_.size()) {}

    void add(SelectedValue& value, const Candidate& candidate) {
        const auto& selection = output_.selections[value.selection];
        const bool each = selection.message == MessageScope::variable;
        value.topic = selection.topic.expand({.output = output_.name,
                                              .line = candidate.line,
                                              .device = candidate.device,
                                              .variable = candidate.name});
        if (is_control(value.topic) && !reported_[value.selection]) return report_reserved(value);
        Owner owner{.subject = value.subject, .label = candidate.name, .exclusive = each || selection.retain};
        if (!each) {
            owner.subject = device_of(value.subject);
            owner.label = candidate.device;
        }
        const auto [first, is_new] = owners_.try_emplace(value.topic, owner);
        if (is_new || first->second.subject == owner.subject ||
            (!owner.exclusive && !first->second.exclusive) || reported_[value.selection])
            return;
        reported_[value.selection] = true;
        entries_[value.selection]->reader().report(Rule::topic_shared, "topic", {},
                                                   {{"topic", value.topic},
                                                    {"first", std::string(first->second.label)},
                                                    {"second", std::string(owner.label)}});
    }

private:
    struct Owner {
        OutputSubject subject;  ///< of messages of a device: with the variable 0; of locals: the local 0
        std::string_view label;
        bool exclusive = true;  ///< no other may have the topic
    };

    /// Whether other messages than samples have the topic.
    [[nodiscard]] bool is_control(std::string_view topic) const {
        const auto& above = output_.mqtt.control_topic;
        if (!topic.starts_with(above) || !topic.substr(above.size()).starts_with('/')) return false;
        const auto level = topic.substr(above.size() + 1);
        return std::ranges::find(control_levels(), level.substr(0, level.find('/'))) !=
               control_levels().end();
    }

    void report_reserved(const SelectedValue& value) {
        reported_[value.selection] = true;
        std::string levels;
        for (const auto level : control_levels()) levels.append(levels.empty() ? "" : ", ").append(level);
        entries_[value.selection]->reader().report(
            Rule::topic_reserved, "topic", {},
            {{"topic", value.topic}, {"control", output_.mqtt.control_topic}, {"levels", levels}});
    }

    static OutputSubject device_of(const OutputSubject& subject) {
        const auto* const polled = std::get_if<PolledIndex>(&subject);
        if (polled == nullptr) return LocalIndex{0};
        return PolledIndex{polled->line, polled->device, 0};
    }

    Interpretation& state_;
    Output& output_;
    std::vector<SelectionEntry*> entries_;
    std::vector<bool> reported_;
    std::map<std::string, Owner, std::less<>> owners_;
};

/// The selections of one output.
class Selections {
public:
    Selections(Interpretation& state, Reader& reader, Output& output)
        : state_(state),
          output_(output),
          mqtt_(output.transport == OutputTransport::mqtt),
          own_(state, reader, {}, mqtt_) {}

    void read() {
        read_entries();
        if (entries_.empty()) {
            output_.selections.push_back(own_.settle(mqtt_));
        } else {
            for (auto& entry : entries_) output_.selections.push_back(entry.settle(mqtt_));
        }
        const auto all = candidates(state_.project);
        distribute(all);
        report(all);
    }

private:
    void read_entries() {
        const Node* const list = own_.reader().list("select");
        if (list == nullptr) return;
        if (list->items.empty()) own_.reader().report(Rule::field_empty, "select", {}, {{"key", "select"}});
        for (std::size_t i = 0; i < list->items.size(); ++i) {
            const auto& item = list->items[i];
            const auto path = own_.reader().path_of("select") + "[" + std::to_string(i) + "]";
            if (is_mapping(state_, item, path))
                entries_.emplace_back(
                    state_, Reader(state_.findings, item, path, Object::output_selection, state_.context),
                    own_.keys(), mqtt_);
        }
    }

    void distribute(const std::vector<Candidate>& all) {
        std::vector<SelectionEntry*> owners;
        for (auto& entry : entries_) owners.push_back(&entry);
        if (owners.empty()) owners.push_back(&own_);
        Topics topics(state_, output_, owners);
        for (const auto& candidate : all) {
            const bool allowed = own_.filter().select(candidate, !entries_.empty());
            std::optional<std::size_t> taken =
                entries_.empty() ? std::optional<std::size_t>(0) : std::nullopt;
            for (std::size_t i = 0; i < entries_.size(); ++i)
                if (entries_[i].filter().select(candidate) && !taken) taken = i;
            if (!allowed || !taken) continue;
            owners[*taken]->count(candidate);
            SelectedValue value{.subject = candidate.subject, .selection = *taken, .topic = {}};
            if (mqtt_) topics.add(value, candidate);
            output_.values.push_back(std::move(value));
        }
    }

    void report(const std::vector<Candidate>& all) {
        own_.filter().report_unused(state_, all);
        for (auto& entry : entries_) {
            entry.filter().report_unused(state_, all);
            if (entry.values() == 0 && entry.filter().all_found())
                state_.findings.add(Rule::output_select_empty, entry.reader().node().location,
                                    entry.reader().path_of("variables"), {});
            report_dead_band(entry);
        }
        if (entries_.empty()) report_dead_band(own_);
        if (output_.values.empty() && own_.filter().all_found())
            state_.findings.add(Rule::output_empty, output_.location, own_.reader().path_of("variables"), {});
    }

    static void report_dead_band(SelectionEntry& entry) {
        if (entry.reader().given("dead_band") && entry.values() > 0 && !entry.numbers())
            entry.reader().report_without_effect("dead_band", "type: bool, string");
    }

    Interpretation& state_;
    Output& output_;
    bool mqtt_;
    SelectionEntry own_;
    std::vector<SelectionEntry> entries_;
};

Variable& variable_of(Project& project, const PolledIndex& index) {
    return project.lines[index.line].devices[index.device].variables[index.variable];
}

void use_services_of(Interpretation& state, const Node& mapping, const std::string& path) {
    const Node* const list = mapping.find("variables");
    if (list == nullptr || list->kind != Node::Kind::list) return;
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        if (item.kind == Node::Kind::scalar && !is_wildcard(item.text) && !state.names.contains(item.text) &&
            resembles_service_name(item.text))
            (void)use_service(state, item.text, item.location,
                              path + ".variables[" + std::to_string(i) + "]");
    }
}

}  // namespace

void use_services_of_outputs(Interpretation& state, const Reader& project) {
    const Node* const outputs = project.value("outputs");
    if (outputs == nullptr) return;
    for (std::size_t i = 0; i < outputs->items.size(); ++i) {
        const auto path = "outputs[" + std::to_string(i) + "]";
        use_services_of(state, outputs->items[i], path);
        const Node* const select = outputs->items[i].find("select");
        for (std::size_t j = 0; select != nullptr && j < select->items.size(); ++j)
            use_services_of(state, select->items[j], path + ".select[" + std::to_string(j) + "]");
    }
}

void read_selections(Interpretation& state, Reader& reader, Output& output) {
    Selections(state, reader, output).read();
}

void read_commands(Interpretation& state, Reader& reader, Output& output) {
    if (!reader.given("commands")) return;
    PatternList patterns(state, reader, "commands");
    NameFilter writable;
    for (std::size_t i = 0; i < patterns.size(); ++i) writable.add(patterns.pattern(i));
    std::vector<std::string_view> names;
    for (const auto& each : candidates(state.project)) {
        if (each.service) {
            patterns.select_exactly(each.name);
            continue;
        }
        if (names.size() < kNamesToCompare) names.push_back(each.name);
        if (!patterns.select(each.name) || (each.variable != nullptr && !each.variable->write)) continue;
        writable.select(each.name);
        output.commandable.push_back(each.subject);
        if (const auto* const polled = std::get_if<PolledIndex>(&each.subject))
            variable_of(state.project, *polled).written_by_clients = true;
    }
    for (std::size_t i = 0; i < patterns.size(); ++i) {
        const auto& pattern = patterns.pattern(i);
        if (is_service_name(pattern))
            patterns.report(state, Rule::service_read_only, i);
        else if (patterns.used(i) && !writable.used(i))
            patterns.report(state,
                            is_wildcard(pattern) ? Rule::output_none_writable : Rule::output_not_writable, i);
        else if (!patterns.used(i) && is_wildcard(pattern))
            patterns.report(state, Rule::output_unmatched, i, {{"kind", "variable"}});
        else if (!patterns.used(i) && names.empty())
            patterns.report(state, Rule::name_none, i, {{"kind", "variable"}});
        else if (!patterns.used(i))
            patterns.report(state, Rule::output_unknown, i,
                            {{"kind", "variable"}, {"nearest", std::string(nearest(pattern, names))}});
    }
}

}  // namespace takt::model
