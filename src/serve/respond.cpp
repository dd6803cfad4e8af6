// The functions that reach the banks (MODBUS Application Protocol V1.1b3, sections 6.1..6.6, 6.11, 6.12,
// 6.16, 6.17).
#include <array>

#include "pdu_bytes.hpp"
#include "takt/base/assert.hpp"
#include "takt/serve/server.hpp"

namespace takt::serve {
namespace {

using wire::Area;
using wire::ExceptionCode;
using wire::Function;

/// Returns nothing if the access is allowed.
using Refusal = std::optional<ExceptionCode>;

constexpr std::size_t kWriteHead = 5;  // function, address, quantity

/// Whether the banks answer the function. A broadcast executes those that only write.
bool is_of_banks(Function function, bool broadcast) {
    const auto& row = wire::properties(function);
    return row.most_items > 0 && (!broadcast || row.only_writes_items());
}

/// Executes one request on one unit.
class Execution {
public:
    /// @param request  of one of these functions
    Execution(Unit& unit, const Context& context, const wire::RequestView& request, wire::Pdu& out)
        : unit_(unit), context_(context), request_(request), out_(out) {}

    Refusal run() {
        if (!request_.well_formed()) return ExceptionCode::illegal_data_value;
        const auto& row = wire::properties(request_.function());
        switch (row.request) {
            case wire::RequestForm::range: return row.counts_bits() ? read_bits() : read_registers();
            case wire::RequestForm::single:
                if (row.counts_bits()) return write_coil();
                return write(access(0, request_.values()), request_.pdu());
            case wire::RequestForm::masks: return mask_register();
            case wire::RequestForm::exchange: return write_and_read();
            default: return write(access(0, request_.values()), request_.pdu().first(kWriteHead));
        }
    }

private:
    Access access(std::size_t index, Bytes values = {}) const {
        const wire::ItemAccess& items = request_.accesses()[index];
        return {request_.function(), items.area, items.start, items.count, items.write, values};
    }

    Refusal read_bits() {
        const Access items = access(0);
        if (const Refusal refusal = admit(items)) return refusal;
        begin_read((items.count + 7U) / 8);
        for (std::uint32_t i = 0; i < items.count; i += 8) out_.push_back(bits_from(items, i));
        return {};
    }

    Refusal read_registers() {
        const Access items = access(0);
        if (const Refusal refusal = admit(items)) return refusal;
        load(items);
        return {};
    }

    Refusal write_coil() {
        const std::uint8_t on = request_.values()[0] != 0;
        return write(access(0, Bytes(&on, 1)), request_.pdu());
    }

    Refusal mask_register() {
        Access items = access(0);
        if (!unit_.banks.writable(items.area, items.start, 1)) return ExceptionCode::illegal_data_address;
        std::array<std::uint8_t, 2> result = masked(items.start);
        items.values = result;
        if (!unit_.banks.admits(items.area, items.start, 1, result)) return ExceptionCode::illegal_data_value;
        if (const Refusal refusal = ask(items)) return refusal;
        result = masked(items.start);  // the hook may have updated the register
        store(items);
        out_.assign(request_.pdu());
        return {};
    }

    std::array<std::uint8_t, 2> masked(std::uint16_t address) const {
        const unsigned old = unit_.banks.holding_registers.get(address);
        const unsigned and_mask = word(request_.values(), 0);
        const unsigned value = (old & and_mask) | (word(request_.values(), 2) & ~and_mask);
        return {static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
    }

    Refusal write_and_read() {
        const Access read = access(0);
        const Access write = access(1, request_.values());
        const Banks& banks = unit_.banks;
        if (!banks.writable(write.area, write.start, write.count) ||
            !banks.readable(read.area, read.start, read.count))
            return ExceptionCode::illegal_data_address;
        if (!banks.admits(write.area, write.start, write.count, write.values))
            return ExceptionCode::illegal_data_value;
        if (const Refusal refusal = ask(write)) return refusal;
        if (const Refusal refusal = ask(read)) return refusal;
        store(write);
        load(read);
        return {};
    }

    Refusal ask(const Access& access) {
        return unit_.hooks ? unit_.hooks->before(context_, access) : Refusal{};
    }

    Refusal admit(const Access& access) {
        const Banks& banks = unit_.banks;
        const bool possible = access.write ? banks.writable(access.area, access.start, access.count)
                                           : banks.readable(access.area, access.start, access.count);
        if (!possible) return ExceptionCode::illegal_data_address;
        if (access.write && !banks.admits(access.area, access.start, access.count, access.values))
            return ExceptionCode::illegal_data_value;
        return ask(access);
    }

    Refusal write(const Access& access, Bytes confirmation) {
        if (const Refusal refusal = admit(access)) return refusal;
        store(access);
        out_.assign(confirmation);
        return {};
    }

    void store(const Access& access) {
        for (std::uint16_t i = 0; i < access.count; ++i) {
            const auto address = static_cast<std::uint16_t>(access.start + i);
            if (wire::is_bit_area(access.area))
                unit_.banks.set_bit(access.area, address, (access.values[i / 8U] >> (i % 8U) & 1) != 0);
            else
                unit_.banks.holding_registers.set(address, word(access.values, std::size_t{2} * i));
        }
        if (unit_.hooks) unit_.hooks->written(context_, access);
    }

    void begin_read(std::size_t bytes) {
        out_.push_back(request_.pdu()[0]);
        out_.push_back(static_cast<std::uint8_t>(bytes));
    }

    void load(const Access& access) {
        begin_read(std::size_t{2} * access.count);
        const RegisterBank& bank = unit_.banks.registers(access.area);
        for (std::uint16_t i = 0; i < access.count; ++i)
            put_word(out_, bank.get(static_cast<std::uint16_t>(access.start + i)));
    }

    std::uint8_t bits_from(const Access& access, std::uint32_t first) const {
        unsigned byte = 0;
        for (std::uint32_t i = first; i < first + 8 && i < access.count; ++i)
            if (unit_.banks.bit(access.area, static_cast<std::uint16_t>(access.start + i)))
                byte |= 1U << (i - first);
        return static_cast<std::uint8_t>(byte);
    }

    Unit& unit_;
    const Context& context_;
    const wire::RequestView& request_;
    wire::Pdu& out_;
};

bool extended(Unit& unit, const Context& context, const wire::RequestView& request, Answer& answer) {
    for (Extension* extension : unit.extensions)
        if (extension->handle(unit, context, request, answer)) return true;
    return false;
}

void execute(Unit& unit, const Context& context, const wire::RequestView& request, Answer& answer) {
    Refusal refusal;
    if (is_of_banks(request.function(), context.broadcast))
        refusal = Execution(unit, context, request, answer.pdu).run();
    else if (wire::is_exception(request.pdu()[0]) || !extended(unit, context, request, answer))
        refusal = ExceptionCode::illegal_function;
    if (refusal) refuse(answer, request, *refusal);
}

}  // namespace

wire::Pdu exception_to(std::uint8_t function, ExceptionCode code) {
    return {wire::exception_function(function), static_cast<std::uint8_t>(code)};
}

Answer respond(Unit& unit, const Context& context, const wire::RequestView& request) {
    Answer answer;
    respond(unit, context, request, answer);
    return answer;
}

void respond(Unit& unit, const Context& context, const wire::RequestView& request, Answer& answer) {
    TAKT_ASSERT(!request.empty());
    answer.kind = Answer::Kind::silence;
    answer.delay = {};
    answer.pdu.clear();
    bool admitted = true;
    for (Extension* extension : unit.extensions) admitted = extension->admit(context, request) && admitted;
    if (admitted) {
        answer.kind = Answer::Kind::response;
        execute(unit, context, request, answer);
        if (unit.hooks) unit.hooks->handled(context, request, answer);
    }
    for (Extension* extension : unit.extensions) extension->done(context, request, answer);
}

}  // namespace takt::serve
