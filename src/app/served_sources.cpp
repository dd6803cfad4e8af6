#include "served_sources.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "served_server.hpp"
#include "takt/app/log.hpp"
#include "takt/poll/project_slots.hpp"

namespace takt::app {
namespace {

std::string folder_of(const model::Project& project) {
    if (project.files.empty()) return {};
    return std::filesystem::path(project.files[0]).parent_path().string();
}

bool is_of_line(const model::Binding& binding) {
    const bool read = binding.source && std::holds_alternative<model::VariableSource>(*binding.source);
    return read || (binding.sink && std::holds_alternative<model::VariableSource>(*binding.sink));
}

}  // namespace

ServedValues::ServedValues(const model::Project& project) : store_(poll::slot_infos(project)) {}

Result<bool> ServedValues::set(value::SlotId local, const value::Value& value) {
    const value::Update update{local, value, value::Quality::good, value::Reason::ok};
    store_.apply(line::now(), {&update, 1});
    return false;
}

Result<bool> ServedValues::write(value::SlotId variable, const value::Value&, Running::Written) {
    return fail(Code::timed_out, store_.info(variable).name);
}

void ServedSources::bind(std::size_t server, Place& place) {
    const auto& settings = project_.servers[server];
    if (std::ranges::all_of(settings.units, [](const auto& unit) { return unit.bindings.empty(); })) return;
    auto& served = *place.served;
    // What it refers to lives as long as it does.
    struct Layer {
        Layer(const Place& of, const model::Server& server_settings)
            : inner(of.responder),
              answers(of.answers),
              server(*inner, server_settings, of.served->units(), *answers, answers->tokens()) {}
        std::shared_ptr<serve::Responder> inner;
        std::shared_ptr<line::AnswerRoutes> answers;
        source::BoundServer server;
    };
    const auto layer = std::make_shared<Layer>(place, settings);
    const std::shared_ptr<source::BoundServer> made(layer, &layer->server);
    for (std::size_t i = 0; i < settings.units.size(); ++i) served.served(i).add_hooks(made->hooks(i));
    bound_.push_back(made);
    place.responder = made;
    place.retained_answers = made;
}

Result<void> ServedSources::open(line::Loop& loop) {
    feeds_.emplace(loop, project_, folder_of(project_), values_.store(), log("source"));
    for (const auto& server : bound_) TAKT_CHECK(server->connect(*feeds_, values_));
    return feeds_->open();
}

void ServedSources::close() {
    for (const auto& server : bound_) server->disconnect();
    feeds_.reset();
}

std::size_t bound_to_lines(const model::Project& project) {
    std::size_t count = 0;
    for (const auto& server : project.servers)
        for (const auto& unit : server.units)
            count += static_cast<std::size_t>(std::ranges::count_if(unit.bindings, is_of_line));
    return count;
}

}  // namespace takt::app
