// A history output at work: the journal into the database of the history.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "takt/publish/output_work.hpp"
#include "takt/publish/sample.hpp"
#include "takt/store/history.hpp"

namespace takt::publish {

/// Commits the records of the journal once a second, and acknowledges them after that. A database that cannot
/// be opened or written is tried again; the journal keeps the samples meanwhile.
class HistoryWork final : public OutputWork {
public:
    /// @param path            of the database
    /// @param journal_folder  keeps the identity of the journal; exists when begin() is called
    HistoryWork(std::string path, std::string journal_folder, const store::HistoryOptions& options)
        : path_(std::move(path)), journal_folder_(std::move(journal_folder)), options_(options) {}

    void begin(Instant now, store::Journal& journal, store::DestinationId destination) override;
    void work(Instant now) override;
    [[nodiscard]] Instant next_wakeup() const override { return next_; }
    [[nodiscard]] std::span<const int> descriptors() const override { return {}; }
    void on_state_changed(Instant) override {}
    /// stop() takes the rest.
    [[nodiscard]] bool takes_records() const override { return false; }
    void stop(Instant now) override;
    [[nodiscard]] bool stopped() const override { return stopped_; }
    void report(Instant now, OutputStatus& status) const override;

private:
    static constexpr Duration kCommitEvery = std::chrono::seconds(1);
    static constexpr Duration kTryAgain = std::chrono::seconds(5);
    /// Records between two commits: they are in memory, and repeated after a crash.
    static constexpr std::size_t kMostRecords = 256;

    [[nodiscard]] Result<void> open();
    /// Commits at most kMostRecords. @returns whether more wait
    [[nodiscard]] Result<bool> take(Instant now);
    [[nodiscard]] Result<void> append(const store::JournalEntry& entry);
    [[nodiscard]] Result<store::SeriesId> series_of(const Series& series);
    void fail_with(Instant now, const Error& error);

    std::string path_;
    std::string journal_folder_;
    store::HistoryOptions options_;
    store::Journal* journal_ = nullptr;
    store::DestinationId destination_;
    std::uint64_t identity_ = 0;  // of the journal
    std::unique_ptr<store::History> history_;
    std::map<std::string, std::pair<Series, store::SeriesId>> series_;  // by variable
    std::size_t records_ = 0;                                           // appended and not committed
    std::uint64_t last_sequence_ = 0;                                   // of them
    std::uint64_t unreadable_ = 0;  // samples of records of another version
    Instant next_{};
    std::optional<Error> failure_;
    std::string set_aside_;      // where a damaged file was moved
    std::uint64_t damaged_ = 0;  // rows that gaps replaced
    bool stopped_ = false;
};

}  // namespace takt::publish
