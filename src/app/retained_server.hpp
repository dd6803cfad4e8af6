// Registers of units that survive the end of the program, and answers that wait until they do (specification,
// section 9).
#pragma once

#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "served_server.hpp"
#include "takt/app/texts.hpp"
#include "takt/line/loop.hpp"
#include "takt/report/serve_report.hpp"
#include "takt/serve/server.hpp"
#include "takt/store/register_keeper.hpp"

namespace takt::app {

/// What of a unit is kept, and how.
struct RetainPlan {
    std::array<std::vector<serve::AddressRange>, 4> items;  ///< by wire::Area
    store::Durability durability = store::Durability::acknowledged;
    std::string path;
};

/// One unit. Writes are in force at once; with Durability::acknowledged their answers wait for the disk.
/// Where the disk fails all that wait are refused with exception 4, and the items have the values again that
/// are on the disk. The loop's thread only.
class RetainedUnit final : public serve::UnitHooks {
public:
    /// Answers that may wait; further writes are refused with exception 6 before anything is done.
    static constexpr std::size_t kMostWaiting = 65536;

    /// @param unit  outlives it; what hooks it has stay in force
    RetainedUnit(serve::Unit& unit, RetainPlan plan);
    ~RetainedUnit() = default;
    RetainedUnit(const RetainedUnit&) = delete;
    RetainedUnit& operator=(const RetainedUnit&) = delete;

    /// Opens the file and gives the items their values; says what there is to say of it.
    /// @param answers  outlives it
    /// @returns out_of_range (an item that is not there: its address), and as store::open_registers()
    [[nodiscard]] Result<void> open(line::Loop& loop, const Texts& texts, serve::AnswerSink& answers);

    /// What becomes of an answer to the request that was just handled.
    [[nodiscard]] serve::Answer hold(const serve::Answer& answer, serve::Tokens& tokens);
    /// Whether items were written since hold() was called last.
    [[nodiscard]] bool touched() const { return touched_; }

    /// Writes the rest, and answers all who wait.
    void finish();

    [[nodiscard]] report::RetainedSummary summary() const;

    // serve::UnitHooks
    std::optional<wire::ExceptionCode> before(const serve::Context& context,
                                              const serve::Access& access) override;
    void written(const serve::Context& context, const serve::Access& access) override;

private:
    /// Items side by side, with their place in the image.
    struct Piece {
        wire::Area area = wire::Area::holding_register;
        serve::AddressRange items;
        std::size_t offset = 0;
    };
    struct Waiting {
        std::uint64_t ticket = 0;
        serve::Token token = 0;
        wire::Pdu pdu;
    };

    Result<void> lay_out();
    [[nodiscard]] store::RegisterLayout layout() const;
    [[nodiscard]] std::vector<std::uint8_t> image() const;
    void restore(Bytes image);
    void append(const Piece& piece, unsigned first, unsigned last, std::vector<std::uint8_t>& bytes) const;
    void tell(const Texts& texts, const store::OpenedRegisters& opened) const;
    void settle();
    void refuse_all(const Error& why);

    serve::Unit& unit_;
    serve::UnitHooks* next_;
    RetainPlan plan_;
    std::vector<Piece> pieces_;
    std::optional<Texts> texts_;
    serve::AnswerSink* answers_ = nullptr;
    std::unique_ptr<store::RegisterKeeper> keeper_;
    std::uint64_t ticket_ = 0;   // of the last change
    std::uint64_t durable_ = 0;  // the last ticket that is on the disk
    bool touched_ = false;
    std::deque<Waiting> waiting_;  // by ticket
    Instant next_failure_told_ = Instant::min();
    std::vector<std::uint8_t> bytes_;  // of one request's changes
    std::vector<store::RegisterKeeper::Change> changes_;
    std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // for what the writing thread posted
};

/// The units of a responder of which something is kept, and the answers that wait for it.
class RetainedServer final : public serve::Responder {
public:
    /// @param responder  answers; it is kept alive
    explicit RetainedServer(std::shared_ptr<serve::Responder> responder) : responder_(std::move(responder)) {}

    /// @param unit  one of the responder's
    void add(serve::Unit& unit, RetainPlan plan) {
        units_.push_back(std::make_unique<RetainedUnit>(unit, std::move(plan)));
    }

    /// To be called once, before anything is asked. @returns as RetainedUnit::open()
    /// @param answers, tokens  of those that wait; outlive it
    [[nodiscard]] Result<void> open(line::Loop& loop, const Texts& texts, serve::AnswerSink& answers,
                                    serve::Tokens& tokens);
    void finish();
    [[nodiscard]] std::vector<report::RetainedSummary> summary() const;

    [[nodiscard]] bool serves(UnitId unit) const override { return responder_->serves(unit); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context, Bytes pdu) override;
    void heard(serve::LineEvent event) override { responder_->heard(event); }
    void forget(serve::Token token) override { responder_->forget(token); }

private:
    std::shared_ptr<serve::Responder> responder_;
    std::vector<std::unique_ptr<RetainedUnit>> units_;
    serve::Tokens* tokens_ = nullptr;  // once it is open
};

}  // namespace takt::app
