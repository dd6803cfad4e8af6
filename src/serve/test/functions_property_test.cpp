// The engine reads requests in place; the codec of wire decodes the same bytes into structures. They
// must agree on what is well formed, and a master must understand every answer.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>

#include "support.hpp"
#include "takt/serve/diagnostics.hpp"
#include "takt/serve/fifos.hpp"
#include "takt/serve/files.hpp"
#include "takt/serve/identification.hpp"

namespace takt::serve {
namespace functions_property_test {

using Pdu = std::vector<std::uint8_t>;

void put(Pdu& pdu, unsigned value) {
    pdu.push_back(static_cast<std::uint8_t>(value >> 8));
    pdu.push_back(static_cast<std::uint8_t>(value));
}

unsigned small_or(unsigned most) {
    return *rc::gen::weightedOneOf<unsigned>({{6, rc::gen::inRange(0U, 6U)},
                                              {2, rc::gen::inRange(most - 2, most + 3)},
                                              {1, rc::gen::inRange(0U, 65536U)}});
}

void put_file_parts(Pdu& pdu, bool write) {
    const int parts = *rc::gen::inRange(1, 4);
    for (int i = 0; i < parts; ++i) {
        const unsigned length =
            *rc::gen::weightedElement<unsigned>({{9, 1}, {4, 3}, {1, 124}, {1, 125}, {1, 0}});
        pdu.push_back(*rc::gen::weightedElement<std::uint8_t>({{20, 6}, {1, 5}}));
        put(pdu, *rc::gen::inRange(0U, 3U));
        put(pdu, small_or(20));
        put(pdu, length);
        if (write)
            for (unsigned k = 0; k < length; ++k) put(pdu, k);
    }
    pdu.insert(pdu.begin() + 1, static_cast<std::uint8_t>(pdu.size() - 1));
}

/// A request that is nearly right.
Pdu request_of(std::uint8_t function) {
    Pdu pdu{function};
    const auto items = [&](unsigned most, bool bits) {
        const unsigned quantity =
            *rc::gen::weightedOneOf<unsigned>({{6, rc::gen::inRange(1U, 9U)},
                                               {1, rc::gen::inRange(most - 1, most + 2)},
                                               {1, rc::gen::just(0U)}});
        put(pdu, quantity);
        const unsigned bytes = bits ? (quantity + 7) / 8 : 2 * quantity;
        pdu.push_back(static_cast<std::uint8_t>(bytes));
        for (unsigned i = 0; i < bytes; ++i) pdu.push_back(static_cast<std::uint8_t>(i * 7));
    };
    switch (function) {
        case 1:
        case 2:
        case 3:
        case 4: put(pdu, small_or(40)), put(pdu, small_or(function < 3 ? 2000 : 125)); break;
        case 5: put(pdu, small_or(40)), put(pdu, *rc::gen::element(0U, 0xFF00U, 1U)); break;
        case 6: put(pdu, small_or(40)), put(pdu, small_or(100)); break;
        case 8:
            put(pdu, *rc::gen::inRange(0U, 22U)), put(pdu, *rc::gen::element(0U, 0xFF00U, 0x0A00U, 7U));
            break;
        case 15: put(pdu, small_or(40)), items(1968, true); break;
        case 16: put(pdu, small_or(40)), items(123, false); break;
        case 20:
        case 21: put_file_parts(pdu, function == 21); break;
        case 22: put(pdu, small_or(40)), put(pdu, 0xF0F0), put(pdu, 0x1234); break;
        case 23:
            put(pdu, small_or(40)), put(pdu, small_or(125)), put(pdu, small_or(40)), items(121, false);
            break;
        case 24: put(pdu, *rc::gen::inRange(0U, 3U)); break;
        case 43:
            pdu.push_back(*rc::gen::weightedElement<std::uint8_t>({{8, 14}, {1, 13}}));
            pdu.push_back(*rc::gen::inRange<std::uint8_t>(0, 6));
            pdu.push_back(*rc::gen::element<std::uint8_t>(0, 1, 4, 0x80, 0xFF));
            break;
        default: break;
    }
    const int mutation = *rc::gen::inRange(0, 10);
    if (mutation == 0) pdu.pop_back();
    if (mutation == 1) pdu.push_back(0);
    if (mutation == 2)
        pdu[*rc::gen::inRange<std::size_t>(0, pdu.size())] = *rc::gen::arbitrary<std::uint8_t>();
    if (pdu.size() > wire::kMaxPdu) pdu.resize(wire::kMaxPdu);
    if (pdu.empty()) pdu.push_back(function);
    pdu.shrink_to_fit();
    return pdu;
}

struct Everything {
    Everything() {
        extensions = {&diagnostics, &identification, &files, &fifos};
        units[0] = {UnitId{1}, storage.banks(), nullptr, extensions};
    }
    Storage storage{40};
    EventLog log;
    Diagnostics diagnostics{{true, false, std::uint16_t{3}}, &log};
    std::array<IdentificationObject, 4> objects{{{0, "a"}, {1, "b"}, {2, "c"}, {0x80, "own"}}};
    std::array<std::uint8_t, 1> id{1};
    Identification identification{objects, id};
    std::array<std::uint16_t, 20> records{};
    std::array<File, 2> file_list{{{1, records, false}, {2, records, true}}};
    Files files{file_list};
    std::array<std::uint16_t, 3> queue{1, 2, 3};
    std::array<Fifo, 2> fifo_list{{{0, queue}, {1, {}}}};
    Fifos fifos{fifo_list};
    std::array<Extension*, 4> extensions{};
    std::array<Unit, 1> units;
};

RC_GTEST_PROP(Functions, TheEngineAndTheCodecAgree, ()) {
    Everything all;
    const auto function =
        *rc::gen::element<std::uint8_t>(1, 2, 3, 4, 5, 6, 7, 8, 11, 12, 15, 16, 17, 20, 21, 22, 23, 24, 43);
    const Pdu pdu = request_of(function);
    const auto typed = wire::decode_request(pdu);
    const Storage before = all.storage;
    const auto records = all.records;
    const Answer answer = respond(all.units[0], {{}, UnitId{1}, false, {}, {}}, wire::RequestView(pdu));
    RC_ASSERT(answer.kind == Answer::Kind::response);
    if (answer.pdu[0] == pdu[0] && pdu[0] < 0x80) {
        RC_TAG("answered");
        RC_ASSERT(typed.has_value());
        const auto understood = wire::decode_response(*typed, answer.pdu.span());
        RC_ASSERT(understood.has_value());
        RC_ASSERT(!std::holds_alternative<wire::ExceptionResponse>(*understood));
        return;
    }
    RC_ASSERT(answer.pdu.size() == 2u);
    RC_ASSERT(answer.pdu[0] == (pdu[0] | 0x80));
    RC_ASSERT(all.storage == before);
    RC_ASSERT(all.records == records);
    RC_TAG(std::to_string(answer.pdu[1]));
    // The data of a sub-function, which wire does not check.
    const bool data_value = pdu[0] == 8 && typed.has_value();
    if (answer.pdu[1] == 3) {
        RC_ASSERT(!typed.has_value() || data_value);
    } else if (answer.pdu[1] == 2) {
        RC_ASSERT(typed.has_value());
    } else {
        RC_ASSERT(answer.pdu[1] == 1);
    }
}

/// A bank as a plain map from address to value.
RC_GTEST_PROP(Banks, LayoutsHoldWhatIsWritten, ()) {
    std::vector<AddressRange> offered;
    std::size_t stored = 0;
    std::uint32_t next = 0;
    const int ranges = *rc::gen::inRange(1, 5);
    for (int i = 0; i < ranges; ++i) {
        const std::uint32_t first = next + *rc::gen::inRange(0U, 4U);
        const std::uint32_t last = first + *rc::gen::inRange(0U, 5U);
        offered.push_back({static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(last)});
        stored += last - first + 1;
        next = last + 1;
    }
    std::vector<std::uint16_t> values(stored);
    Banks banks;
    banks.holding_registers = {0, values, offered, {}, {}, true};
    banks.coils.count = 1600;
    banks.coils.overlay = BitOverlay{};
    for (unsigned address = 0; address < next; ++address) {
        const auto one = static_cast<std::uint16_t>(address);
        const bool exists =
            std::ranges::any_of(offered, [&](auto range) { return range.first <= one && one <= range.last; });
        RC_ASSERT(banks.readable(wire::Area::holding_register, one, 1) == exists);
        RC_ASSERT(banks.writable(wire::Area::coil, static_cast<std::uint16_t>(16 * one), 16) == exists);
        if (exists) banks.holding_registers.set(one, static_cast<std::uint16_t>(one * 257 + 1));
    }
    for (const AddressRange& range : offered)
        for (unsigned address = range.first; address <= range.last; ++address) {
            const auto one = static_cast<std::uint16_t>(address);
            const auto expected = static_cast<std::uint16_t>(one * 257 + 1);
            RC_ASSERT(banks.holding_registers.get(one) == expected);
            for (unsigned bit = 0; bit < 16; ++bit)
                RC_ASSERT(banks.bit(wire::Area::coil, static_cast<std::uint16_t>(16 * one + bit)) ==
                          ((expected >> bit & 1) != 0));
        }
}

}  // namespace functions_property_test
}  // namespace takt::serve
