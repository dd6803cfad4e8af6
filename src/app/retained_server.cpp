#include "retained_server.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "takt/app/console.hpp"
#include "takt/base/assert.hpp"

namespace takt::app {
namespace {

using store::Durability;
using wire::Area;

constexpr Duration kTellEvery = std::chrono::seconds(1);
constexpr unsigned kBitsInARegister = 16;

bool exists(const serve::Banks& banks, Area area, serve::AddressRange items, unsigned& missing) {
    for (missing = items.first; missing <= items.last; ++missing)
        if (!banks.readable(area, static_cast<std::uint16_t>(missing), 1)) return false;
    return true;
}

/// The registers under bits of an overlaid bank.
serve::AddressRange under(const serve::BitBank& bank, unsigned first, unsigned last) {
    const auto register_of = [&bank](unsigned address) {
        return static_cast<std::uint16_t>(bank.overlay->first + (address - bank.first) / kBitsInARegister);
    };
    return {register_of(first), register_of(last)};
}

std::vector<serve::AddressRange> merged(std::vector<serve::AddressRange> ranges) {
    std::ranges::sort(ranges, {}, &serve::AddressRange::first);
    std::vector<serve::AddressRange> all;
    for (const auto& range : ranges)
        if (!all.empty() && range.first <= all.back().last + 1U)
            all.back().last = std::max(all.back().last, range.last);
        else
            all.push_back(range);
    return all;
}

}  // namespace

RetainedUnit::RetainedUnit(serve::Unit& unit, RetainPlan plan)
    : unit_(unit), next_(std::exchange(unit.hooks, this)), plan_(std::move(plan)) {}

// Bits that lie over registers are kept with these.
Result<void> RetainedUnit::lay_out() {
    std::array<std::vector<serve::AddressRange>, 4> items = plan_.items;
    for (std::size_t i = 0; i < plan_.items.size(); ++i) {
        const Area area{static_cast<std::uint8_t>(i)};
        for (const auto& range : plan_.items[i])
            if (unsigned missing = 0; !exists(unit_.banks, area, range, missing))
                return fail(Code::not_found, std::string(wire::name(area)) + " " + std::to_string(missing));
        if (!wire::is_bit_area(area) || !unit_.banks.bits(area).overlay) continue;
        const serve::BitBank& bits = unit_.banks.bits(area);
        for (const auto& range : plan_.items[i])
            items[static_cast<std::size_t>(bits.overlay->area)].push_back(
                under(bits, range.first, range.last));
        items[i].clear();
    }
    std::size_t offset = 0;
    for (std::size_t i = 0; i < items.size(); ++i)
        for (const auto& range : merged(items[i])) {
            pieces_.push_back({Area{static_cast<std::uint8_t>(i)}, range, offset});
            offset += layout().ranges.back().bytes();
        }
    constexpr auto kMost = store::RegisterLayout::kMostRanges;
    if (pieces_.size() > kMost)
        return fail(Code::too_long, plan_.path, static_cast<std::int64_t>(pieces_.size()),
                    static_cast<std::int64_t>(kMost));
    return {};
}

store::RegisterLayout RetainedUnit::layout() const {
    store::RegisterLayout layout{unit_.id.value, {}};
    for (const auto& piece : pieces_)
        layout.ranges.push_back({static_cast<std::uint8_t>(piece.area), wire::is_bit_area(piece.area),
                                 piece.items.first, piece.items.last});
    return layout;
}

/// The bytes of an image that hold items first..last of a piece.
void RetainedUnit::append(const Piece& piece, unsigned first, unsigned last,
                          std::vector<std::uint8_t>& bytes) const {
    const serve::Banks& banks = unit_.banks;
    if (!wire::is_bit_area(piece.area)) {
        for (unsigned item = first; item <= last; ++item) {
            const unsigned value = banks.registers(piece.area).get(static_cast<std::uint16_t>(item));
            bytes.push_back(static_cast<std::uint8_t>(value >> 8));
            bytes.push_back(static_cast<std::uint8_t>(value));
        }
        return;
    }
    for (unsigned at = (first - piece.items.first) / 8; at <= (last - piece.items.first) / 8; ++at) {
        unsigned byte = 0;
        for (unsigned bit = 0; bit < 8; ++bit) {
            const unsigned item = piece.items.first + at * 8 + bit;
            if (item <= piece.items.last && banks.bit(piece.area, static_cast<std::uint16_t>(item)))
                byte |= 1U << bit;
        }
        bytes.push_back(static_cast<std::uint8_t>(byte));
    }
}

std::vector<std::uint8_t> RetainedUnit::image() const {
    std::vector<std::uint8_t> bytes;
    for (const auto& piece : pieces_) append(piece, piece.items.first, piece.items.last, bytes);
    return bytes;
}

void RetainedUnit::restore(Bytes image) {
    serve::Banks& banks = unit_.banks;
    for (const auto& piece : pieces_)
        for (unsigned item = piece.items.first; item <= piece.items.last; ++item) {
            const auto address = static_cast<std::uint16_t>(item);
            const std::size_t index = item - piece.items.first;
            if (wire::is_bit_area(piece.area)) {
                banks.set_bit(piece.area, address, (image[piece.offset + index / 8] >> (index % 8) & 1) != 0);
            } else {
                const std::size_t at = piece.offset + 2 * index;
                banks.registers(piece.area)
                    .set(address, static_cast<std::uint16_t>(image[at] << 8 | image[at + 1]));
            }
        }
}

Result<void> RetainedUnit::open(line::Loop& loop, const Texts& texts, serve::AnswerSink& answers) {
    TAKT_CHECK(lay_out());
    auto found = store::open_registers(plan_.path, layout(), image());
    if (!found && found.error().code == Code::unsupported)
        print_error(texts("app.registers.foreign", {{"file", plan_.path}}));
    TAKT_TRY(auto opened, std::move(found));
    texts_ = texts;
    answers_ = &answers;
    tell(texts, opened);
    restore(opened.file.image());
    store::RegisterKeeper::Options options;
    options.durability = plan_.durability;
    options.on_progress = [this, &loop, alive = std::weak_ptr(alive_)] {
        loop.post([this, alive] {
            if (!alive.expired()) settle();
        });
    };
    keeper_ = std::make_unique<store::RegisterKeeper>(std::move(opened.storage), std::move(opened.file),
                                                      std::move(options));
    return {};
}

void RetainedUnit::tell(const Texts& texts, const store::OpenedRegisters& opened) const {
    const Texts::Arguments arguments{{"file", plan_.path},
                                     {"unit", std::to_string(unit_.id.value)},
                                     {"aside", opened.set_aside},
                                     {"taken", std::to_string(opened.taken)},
                                     {"missing", std::to_string(opened.missing)},
                                     {"number", std::to_string(opened.file.sequence())}};
    if (opened.is_new && !opened.set_aside.empty())
        print_error(texts("app.registers.damaged", arguments));
    else if (opened.is_new)
        print_status(texts("app.registers.new", arguments) + '\n');
    else if (opened.other_layout)
        print_error(texts("app.registers.other_layout", arguments));
    else if (opened.was_damaged)
        print_error(texts("app.registers.one_copy", arguments));
}

std::optional<wire::ExceptionCode> RetainedUnit::before(const serve::Context& context,
                                                        const serve::Access& access) {
    if (access.write && waiting_.size() >= kMostWaiting) return wire::ExceptionCode::server_device_busy;
    return next_ ? next_->before(context, access) : std::nullopt;
}

void RetainedUnit::written(const serve::Context& context, const serve::Access& access) {
    if (next_) next_->written(context, access);
    if (!keeper_) return;
    Area area = access.area;
    serve::AddressRange items{access.start, static_cast<std::uint16_t>(access.start + access.count - 1U)};
    if (wire::is_bit_area(area) && unit_.banks.bits(area).overlay) {
        const serve::BitBank& bits = unit_.banks.bits(area);
        items = under(bits, items.first, items.last);
        area = bits.overlay->area;
    }
    bytes_.clear();
    changes_.clear();
    constexpr std::size_t kMostBytes = 1024;  // of one request: the spans below stay where they are
    bytes_.reserve(kMostBytes);
    for (const auto& piece : pieces_) {
        const unsigned first = std::max(piece.items.first, items.first);
        const unsigned last = std::min(piece.items.last, items.last);
        if (piece.area != area || first > last) continue;
        const std::size_t index = first - piece.items.first;
        const std::size_t begin = bytes_.size();
        append(piece, first, last, bytes_);
        TAKT_ASSERT(bytes_.size() <= kMostBytes);
        changes_.push_back(
            {piece.offset + (wire::is_bit_area(area) ? index / 8 : 2 * index), Bytes(bytes_).subspan(begin)});
    }
    if (changes_.empty()) return;
    ticket_ = keeper_->change(changes_);
    touched_ = true;
}

serve::Answer RetainedUnit::hold(const serve::Answer& answer, serve::Tokens& tokens) {
    touched_ = false;
    if (plan_.durability != Durability::acknowledged || ticket_ <= durable_ ||
        answer.kind != serve::Answer::Kind::response)
        return answer;
    waiting_.push_back({ticket_, tokens.next(), answer.pdu});
    return serve::Answer::pending(waiting_.back().token);
}

// Who is answered may ask again at once, and be waiting anew.
void RetainedUnit::settle() {
    const auto progress = keeper_->progress();
    durable_ = progress.durable;
    if (progress.failed && (progress.stopped || plan_.durability != Durability::acknowledged))
        return refuse_all(progress.why);
    while (!waiting_.empty() && waiting_.front().ticket <= durable_) {
        const Waiting next = waiting_.front();
        waiting_.pop_front();
        answers_->complete(next.token, next.pdu.span());
    }
}

void RetainedUnit::refuse_all(const Error& why) {
    const Instant t = line::now();
    if (t >= next_failure_told_) {
        next_failure_told_ = after(t, kTellEvery);
        print_error((*texts_)("app.registers.failed",
                              {{"unit", std::to_string(unit_.id.value)}, {"error", texts_->describe(why)}}));
    }
    if (plan_.durability != Durability::acknowledged) return;
    std::vector<std::uint8_t> durable;
    keeper_->roll_back(durable);
    restore(durable);
    durable_ = ticket_;
    for (const Waiting& refused : std::exchange(waiting_, {}))
        answers_->complete(
            refused.token,
            serve::exception_to(refused.pdu[0], wire::ExceptionCode::server_device_failure).span());
}

void RetainedUnit::finish() {
    if (!keeper_) return;
    settle();
    keeper_->close();
    settle();
}

report::RetainedSummary RetainedUnit::summary() const {
    const auto written = keeper_ ? keeper_->counters() : store::RegisterFile::Counters{};
    return {unit_.id, plan_.path, written.commits, written.bytes, written.failures};
}

Result<void> RetainedServer::open(line::Loop& loop, const Texts& texts, serve::AnswerSink& answers,
                                  serve::Tokens& tokens) {
    tokens_ = &tokens;
    for (const auto& unit : units_) TAKT_CHECK(unit->open(loop, texts, answers));
    return {};
}

void RetainedServer::finish() {
    for (const auto& unit : units_) unit->finish();
}

std::vector<report::RetainedSummary> RetainedServer::summary() const {
    std::vector<report::RetainedSummary> all;
    for (const auto& unit : units_) all.push_back(unit->summary());
    return all;
}

serve::Answer RetainedServer::handle(const serve::Context& context, Bytes pdu) {
    serve::Answer answer = responder_->handle(context, pdu);
    for (const auto& unit : units_)
        if (unit->touched()) answer = unit->hold(answer, *tokens_);
    return answer;
}

}  // namespace takt::app
