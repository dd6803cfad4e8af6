// takt listen: a port that is only read.
#include "commands.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "offline/listen_output.hpp"
#include "output.hpp"
#include "takt/capture/line_listener.hpp"
#include "takt/capture/setting_search.hpp"
#include "takt/console/clock_text.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/serial_port.hpp"
#include "takt/line/target.hpp"
#include "takt/report/times/latency_report.hpp"
#include "work_loop.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;

constexpr Duration kListenRedrawEvery = 500ms;
constexpr std::size_t kChunk = 512;

capture::ListenConfig config_of(const ListenOptions& options, const capture::LineSetting& setting,
                                bool has_settings) {
    capture::ListenConfig config{.timeout = options.timeout};
    auto& frames = config.frames;
    frames.framing = setting.framing;
    if (has_settings) frames.character = wire::transmission_time(setting.format, 1);
    frames.pause = setting.framing == wire::Framing::ascii
                       ? Duration(1s)
                       : std::max(frames.pause, wire::t3_5(setting.format));
    return config;
}

/// The port to listen to: a target with its settings, or a device file whose settings are searched.
struct PortChoice {
    model::Line connection;
    bool search = false;
};

PortChoice choice_of(const std::string& port) {
    const bool is_target = port.find("://") != std::string::npos;
    const auto target = line::parse_target(is_target ? port : "rtu://" + port);
    PortChoice choice{.search = !is_target};
    if (target) choice.connection = target->as_line();
    if (!is_target) choice.connection.port = port;
    return choice;
}

class ListenPort {
public:
    ListenPort(const Texts& texts, const ListenOptions& options)
        : texts_(texts),
          options_(options),
          choice_(choice_of(options.port)),
          output_(texts, options, choice_.connection.port, console::iso_time) {}

    ExitCode run() {
        if (!output_.prepare()) return ExitCode::usage;
        if (const auto opened = open(); !opened) return ended_by(texts_, opened.error());
        work_loop_.work(options_.run_for);
        watch_.reset();
        timer_.reset();
        return finish();
    }

private:
    [[nodiscard]] model::Line& connection() { return choice_.connection; }

    Result<void> open() {
        TAKT_CHECK(work_loop_.begin());
        has_settings_ = !line::is_pseudo_terminal(connection().port);
        if (choice_.search && has_settings_)
            search_ = std::make_unique<capture::SettingSearch>();
        else if (choice_.search)
            search_ = std::make_unique<capture::SettingSearch>(connection().format);
        TAKT_TRY(port_, line::SerialPort::open({.path = connection().port,
                                                .format = search_ ? search_->format() : connection().format,
                                                .rs485 = connection().rs485,
                                                .read_only = true}));
        if (!search_) begin({connection().format, connection().framing});
        auto& loop = work_loop_.loop();
        watch_ = std::make_unique<line::Watch>(loop, port_->fd(), [this] { on_readable(); });
        timer_ = std::make_unique<line::Timer>(loop, [this](Instant t) { on_timer(t); });
        watch_->want_read();
        timer_->set(line::now());
        return {};
    }

    void on_readable() {
        const auto read = search_ ? read_searching() : read_listening();
        if (!read) {
            lost_ = read.error();
            return work_loop_.loop().stop();
        }
        watch_->want_read();
        set_timer();
    }

    // A setting that changes drops the characters that came with the one before.
    Result<void> read_searching() {
        std::array<wire::Character, kChunk> characters;
        TAKT_TRY(const auto count, port_->read_characters(characters));
        const auto before = search_->format();
        search_->on_characters(line::now(), std::span(characters).first(count));
        if (search_->found()) return end_search();
        if (search_->format() != before) TAKT_CHECK(port_->set_format(search_->format()));
        return {};
    }

    Result<void> end_search() {
        const auto found = *search_->found();
        if (found.format != search_->format()) TAKT_CHECK(port_->set_format(found.format));
        connection().format = found.format;
        connection().framing = found.framing;
        output_.progress().clear();
        print_status(
            texts_("app.listen.found", {{"port", connection().port},
                                        {"setting", report::line_setting_text(connection(), has_settings_)},
                                        {"characters", std::to_string(search_->characters())},
                                        {"tried", std::to_string(search_->tried())}}) +
            '\n');
        search_.reset();
        begin(found);
        return {};
    }

    void begin(const capture::LineSetting& setting) {
        listener_.emplace(config_of(options_, setting, has_settings_), output_);
    }

    Result<void> read_listening() {
        std::array<std::uint8_t, kChunk> bytes;
        TAKT_TRY(const auto count, port_->read(bytes));
        listener_->on_bytes(line::now(), Bytes(bytes).first(count));
        return {};
    }

    void on_timer(Instant t) {
        if (listener_) listener_->on_tick(t);
        if (stdout_error() != 0) return work_loop_.loop().stop();
        show_progress(t);
        redraw_ = after(t, kListenRedrawEvery);
        set_timer();
    }

    void set_timer() {
        const auto wakeup = listener_ ? listener_->next_wakeup() : kNever;
        timer_->set(std::min(wakeup, redraw_));
    }

    void show_progress(Instant t) {
        if (!listener_) return output_.progress().show(t, {}, searching_text());
        if (!options_.quiet) return;
        const auto& counts = listener_->statistics().counts();
        output_.progress().show(t, {},
                                texts_("app.listen.progress",
                                       {{"port", connection().port},
                                        {"setting", report::line_setting_text(connection(), has_settings_)},
                                        {"requests", std::to_string(counts.requests)},
                                        {"damaged", std::to_string(counts.damaged)}}));
    }

    [[nodiscard]] std::string searching_text() {
        auto tried = connection();
        tried.format = search_->format();
        return texts_("app.listen.searching",
                      {{"port", tried.port},
                       {"setting", has_settings_ ? model::settings_text(tried) : std::string("RTU, ASCII")},
                       {"characters", std::to_string(search_->characters())}});
    }

    ExitCode finish() {
        output_.progress().clear();
        auto code = ExitCode::ok;
        if (listener_) {
            listener_->end();
            const auto counters = port_->counters();
            code = output_.finish(listener_->statistics(), connection(), has_settings_, !choice_.search,
                                  counters.faulty_characters + counters.breaks);
        } else {
            code = output_.nothing_heard(search_->characters());
        }
        return lost_ ? ended_by(texts_, *lost_) : code;
    }

    Texts texts_;
    const ListenOptions& options_;
    PortChoice choice_;
    ListenOutput output_;
    WorkLoop work_loop_;
    bool has_settings_ = true;
    std::unique_ptr<line::SerialPort> port_;
    std::unique_ptr<capture::SettingSearch> search_;  // while the settings are searched
    std::optional<capture::LineListener> listener_;   // afterwards
    std::unique_ptr<line::Watch> watch_;
    std::unique_ptr<line::Timer> timer_;
    Instant redraw_;
    std::optional<Error> lost_;
};

}  // namespace

ExitCode listen(const CommonOptions& common, const ListenOptions& options) {
    const Texts texts(common.language);
    std::error_code ignored;
    if (std::filesystem::is_regular_file(options.port, ignored)) return listen_to_capture(texts, options);
    return ListenPort(texts, options).run();
}

}  // namespace takt::app
