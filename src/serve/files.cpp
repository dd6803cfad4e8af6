// Read response: byte count, then parts of remaining length, reference type 6 and registers (sections 6.14,
// 6.15).
#include "takt/serve/files.hpp"

#include <algorithm>

#include "pdu_bytes.hpp"

namespace takt::serve {
namespace {

using wire::ExceptionCode;
using wire::Function;

constexpr std::uint8_t kReferenceType = 6;

}  // namespace

bool Files::handle(Unit& /*unit*/, const Context& context, const wire::RequestView& request, Answer& answer) {
    const bool write = request.function() == Function::write_file_record;
    if (!write && (request.function() != Function::read_file_record || context.broadcast)) return false;
    if (!request.well_formed()) {
        refuse(answer, request, ExceptionCode::illegal_data_value);
    } else if (!exist(request.file_parts(), write)) {
        refuse(answer, request, ExceptionCode::illegal_data_address);
    } else if (write) {
        this->write(context, request.file_parts());
        answer.pdu.assign(request.pdu());
    } else {
        read(request.file_parts(), answer);
    }
    return true;
}

const File* Files::find(const wire::FilePart& part) const {
    const auto found = std::ranges::find(files_, part.file, &File::number);
    if (found == files_.end() || std::size_t{part.record} + part.length > found->records.size())
        return nullptr;
    return &*found;
}

bool Files::exist(wire::FileParts parts, bool writable) const {
    while (!parts.empty()) {
        const File* const file = find(parts.take());
        if (!file || (writable && file->read_only)) return false;
    }
    return true;
}

void Files::read(wire::FileParts parts, Answer& answer) const {
    answer.pdu.push_back(static_cast<std::uint8_t>(Function::read_file_record));
    answer.pdu.push_back(0);
    while (!parts.empty()) {
        const wire::FilePart part = parts.take();
        answer.pdu.push_back(static_cast<std::uint8_t>(1 + 2 * part.length));
        answer.pdu.push_back(kReferenceType);
        for (const std::uint16_t value : find(part)->records.subspan(part.record, part.length))
            put_word(answer.pdu, value);
    }
    answer.pdu[1] = static_cast<std::uint8_t>(answer.pdu.size() - 2);
}

void Files::write(const Context& context, wire::FileParts parts) const {
    while (!parts.empty()) {
        const wire::FilePart part = parts.take();
        const File& file = *find(part);
        for (std::size_t i = 0; i < part.length; ++i)
            file.records[part.record + i] = word(part.values, 2 * i);
        if (observer_) observer_->written(context, file, part.record, part.length);
    }
}

}  // namespace takt::serve
