// Registers of a unit that survive the end of the program, and writes that wait until they do.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "takt/endpoint/notice.hpp"
#include "takt/endpoint/pending_answers.hpp"
#include "takt/endpoint/spec.hpp"
#include "takt/endpoint/statistics.hpp"
#include "takt/serve/server.hpp"
#include "takt/store/register_writer.hpp"

namespace takt::endpoint {

/// The retained items of one unit, as hooks on it. A write is in force at once. With
/// Durability::acknowledged its answer is put off until the disk has it (decision 0018). If the disk fails,
/// all writes that wait are refused with exception 4, and the items have the values again that are on the
/// disk. The loop's thread only.
class RetainedUnit final : public serve::UnitHooks {
public:
    /// Writes that may wait; further ones are refused with exception 6 before anything is done.
    static constexpr std::size_t kMostWaiting = 65536;

    /// Runs a task on the thread that owns the unit; called on the writing thread.
    using Post = std::function<void(std::function<void()>)>;

    /// @param unit, pending  outlive it
    RetainedUnit(serve::Unit& unit, RetainSpec spec, PendingAnswers& pending, NoticeSink notify);
    ~RetainedUnit() = default;
    RetainedUnit(const RetainedUnit&) = delete;
    RetainedUnit& operator=(const RetainedUnit&) = delete;

    /// Opens the file, gives the items their values, and reports how the file was found.
    /// @returns not_found (an item that does not exist), too_long (ranges), and as store::open_registers()
    [[nodiscard]] Result<void> open(Post post);
    /// The same on a file that the caller opens with layout() and image().
    void begin(store::OpenedRegisters opened, Post post);

    /// The retained items, merged; bits that lie over registers are those registers.
    /// @returns not_found, too_long
    [[nodiscard]] Result<store::RegisterLayout> layout();
    /// The values of the items now.
    [[nodiscard]] std::vector<std::uint8_t> image() const;

    /// Writes the rest, and answers all writes that wait.
    void finish();

    [[nodiscard]] RetainedStatistics statistics() const;
    /// The same into what statistics() returned before, without allocating.
    void refresh(RetainedStatistics& statistics) const;

    // serve::UnitHooks
    std::optional<wire::ExceptionCode> before(const serve::Context& context,
                                              const serve::Access& access) override;
    void written(const serve::Context& context, const serve::Access& access) override;

private:
    /// Items side by side, with their offset in the image.
    struct Piece {
        wire::Area area = wire::Area::holding_register;
        serve::AddressRange items;
        std::size_t offset = 0;
    };
    struct Waiting {
        std::uint64_t ticket = 0;
        serve::Token token = 0;
    };

    void restore(Bytes image);
    void append(const Piece& piece, unsigned first, unsigned last, std::vector<std::uint8_t>& bytes) const;
    void collect_changes(wire::Area area, serve::AddressRange items);
    void report(const store::OpenedRegisters& opened) const;
    void settle();
    void reject_all(const Error& why);

    serve::Unit& unit_;
    RetainSpec spec_;
    PendingAnswers& pending_;
    NoticeSink notify_;
    std::vector<Piece> pieces_;
    std::unique_ptr<store::RegisterWriter> writer_;
    std::uint64_t durable_ = 0;    // the last ticket that is on the disk
    std::deque<Waiting> waiting_;  // by ticket
    Instant next_report_ = Instant::min();
    std::vector<std::uint8_t> bytes_;  // of one request's changes
    std::vector<store::RegisterWriter::Change> changes_;
    std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // for what the writing thread posted
};

}  // namespace takt::endpoint
