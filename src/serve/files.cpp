// Request: byte count, then parts of reference type 6, file, first record and length; a write part is
// followed by its registers. Read response: parts of remaining length, reference type 6 and registers
// (sections 6.14, 6.15).
#include "takt/serve/files.hpp"

#include <algorithm>

#include "pdu_bytes.hpp"

namespace takt::serve {
namespace {

using wire::ExceptionCode;
using wire::Function;

constexpr std::uint8_t kReferenceType = 6;
constexpr std::size_t kHead = 7;
constexpr std::size_t kLeastWrite = kHead + 2;
constexpr std::size_t kMostBytes = 251;  // behind function and byte count
constexpr std::size_t kMostLength = 124;

}  // namespace

struct Files::Part {
    std::uint8_t type = 0;
    std::uint16_t file = 0;
    std::uint16_t record = 0;
    std::uint16_t length = 0;
    Bytes values;      // of a write
    std::size_t size;  // in the request, with its values

    /// The first part; bytes.size() >= kHead. `values` is cut where the bytes end.
    static Part first_of(Bytes bytes, bool write) {
        Part part{bytes[0], word(bytes, 1), word(bytes, 3), word(bytes, 5), {}, kHead};
        if (!write) return part;
        part.values = bytes.subspan(kHead, std::min(bytes.size() - kHead, std::size_t{2} * part.length));
        part.size += part.values.size();
        return part;
    }
};

bool Files::handle(Unit& /*unit*/, const Context& context, Bytes request, Answer& answer) {
    const auto function = static_cast<Function>(request[0]);
    const bool write = function == Function::write_file_record;
    if (!write && (function != Function::read_file_record || context.broadcast)) return false;
    Refusal refusal = ExceptionCode::illegal_data_value;
    if (request.size() >= 2 && request[1] == request.size() - 2) refusal = check(request.subspan(2), write);
    if (refusal) {
        refuse(answer, request[0], *refusal);
    } else if (write) {
        this->write(context, request.subspan(2));
        answer.pdu.assign(request);
    } else {
        read(request.subspan(2), answer);
    }
    return true;
}

const File* Files::find(const Part& part) const {
    const auto found = std::ranges::find(files_, part.file, &File::number);
    if (found == files_.end() || std::size_t{part.record} + part.length > found->records.size())
        return nullptr;
    return &*found;
}

// The lengths of all parts are checked before any address, so that a malformed request is exception 3.
Files::Refusal Files::check(Bytes parts, bool write) const {
    if (parts.size() < (write ? kLeastWrite : kHead)) return ExceptionCode::illegal_data_value;
    std::size_t answered = 0;
    bool exists = true;
    while (!parts.empty()) {
        if (parts.size() < kHead) return ExceptionCode::illegal_data_value;
        const Part part = Part::first_of(parts, write);
        if (part.type != kReferenceType || part.length < 1 || part.length > kMostLength)
            return ExceptionCode::illegal_data_value;
        if (write && part.values.size() != 2U * part.length) return ExceptionCode::illegal_data_value;
        answered += 2 + 2U * part.length;
        const File* const file = find(part);
        exists = exists && file && !(write && file->read_only);
        parts = parts.subspan(part.size);
    }
    if (!write && answered > kMostBytes) return ExceptionCode::illegal_data_value;
    return exists ? Refusal{} : ExceptionCode::illegal_data_address;
}

void Files::read(Bytes parts, Answer& answer) const {
    answer.pdu.push_back(static_cast<std::uint8_t>(Function::read_file_record));
    answer.pdu.push_back(0);
    for (; !parts.empty(); parts = parts.subspan(kHead)) {
        const Part part = Part::first_of(parts, false);
        answer.pdu.push_back(static_cast<std::uint8_t>(1 + 2 * part.length));
        answer.pdu.push_back(kReferenceType);
        for (const std::uint16_t value : find(part)->records.subspan(part.record, part.length))
            put_word(answer.pdu, value);
    }
    answer.pdu[1] = static_cast<std::uint8_t>(answer.pdu.size() - 2);
}

void Files::write(const Context& context, Bytes parts) const {
    while (!parts.empty()) {
        const Part part = Part::first_of(parts, true);
        const File& file = *find(part);
        for (std::size_t i = 0; i < part.length; ++i)
            file.records[part.record + i] = word(part.values, 2 * i);
        if (observer_) observer_->written(context, file, part.record, part.length);
        parts = parts.subspan(part.size);
    }
}

}  // namespace takt::serve
