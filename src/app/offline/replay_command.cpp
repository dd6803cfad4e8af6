#include "commands.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "offline/input_files.hpp"
#include "options/option_error.hpp"
#include "output.hpp"
#include "takt/base/iso_time.hpp"
#include "takt/file/json.hpp"
#include "takt/line/loop.hpp"
#include "takt/publish/message_format.hpp"
#include "takt/publish/project_outputs.hpp"
#include "takt/report/times/history_time.hpp"
#include "takt/store/journal.hpp"
#include "takt/store/posix_journal_storage.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

std::int64_t wall_ns() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
}

/// An output that has a journal to replay, by its name; reports why there is none.
const model::Output* find_output(const Texts& texts, const model::Project& project, const std::string& name) {
    std::string known;
    for (const auto& output : project.outputs) {
        if (output.transport == model::OutputTransport::history) continue;
        if (output.name == name) return &output;
        known += (known.empty() ? "" : ", ") + output.name;
    }
    print_error(known.empty() ? texts("app.replay.none")
                              : option_error_text(texts, word_error("--output", name, known)));
    return nullptr;
}

/// The first record that is not older than `from_ns`; nothing: there is none.
Result<std::optional<std::uint64_t>> first_record(const store::Journal& journal, std::int64_t from_ns) {
    const auto stream = journal.replay(journal.sequence_before(from_ns));
    for (;;) {
        TAKT_TRY(const auto entry, stream->next());
        if (!entry) return std::nullopt;
        if (entry->header.wall_ns >= from_ns) return std::optional(entry->header.sequence);
    }
}

struct Replayed {
    std::uint64_t samples = 0;
    std::uint64_t waiting = 0;
};

Result<Replayed> go_back(const std::string& folder, const model::Output& output, std::int64_t from_ns) {
    if (!std::filesystem::is_directory(folder)) return fail(Code::not_found, folder);
    store::JournalOptions options;
    options.quota_bytes = output.journal.quota;
    options.retention = output.journal.retention;
    TAKT_TRY(const auto storage, store::PosixJournalStorage::open(folder, options.segment_bytes));
    const std::string_view destinations[] = {output.name};
    const auto now = line::now();
    TAKT_TRY(auto journal, store::Journal::open(*storage, options, destinations, now, wall_ns()));
    Replayed replayed;
    TAKT_TRY(const auto sequence, first_record(journal, from_ns));
    if (sequence) {
        TAKT_TRY(replayed.samples, journal.go_back(now, {0}, *sequence));
    }
    TAKT_CHECK(journal.close(now));
    replayed.waiting = journal.counters({0}).waiting;
    return replayed;
}

}  // namespace

ExitCode replay(const CommonOptions& common, const ReplayOptions& options) {
    const Texts texts(common.language);
    const auto loaded = load_to_run(texts, options.file);
    if (!loaded) return ExitCode::usage;
    const auto* const output = find_output(texts, loaded->project, options.output);
    if (output == nullptr) return ExitCode::usage;
    const auto from = report::parse_history_time(options.from, wall_ns());
    if (!from) return ended_with(texts("app.history.no_time", {{"value", options.from}}), ExitCode::usage);
    const auto replayed = go_back(publish::journal_folder(options.file, *output), *output, *from);
    if (!replayed && replayed.error().code == Code::busy)
        return ended_with(texts("app.replay.busy", {{"name", output->name}}), ExitCode::cannot_open);
    if (!replayed) return ended_by(texts, replayed.error());
    if (options.json) {
        auto object = file::Json::object();
        object.set("output", output->name);
        object.set("from", utc_time_text(*from));
        object.set("samples", replayed->samples);
        object.set("waiting", replayed->waiting);
        print(object.dump() + '\n');
    } else {
        print(texts("app.replay.done", {{"name", output->name},
                                        {"samples", std::to_string(replayed->samples)},
                                        {"waiting", std::to_string(replayed->waiting)}}) +
              '\n');
    }
    return replayed->samples > 0 ? ExitCode::ok : ExitCode::no;
}

}  // namespace takt::app
