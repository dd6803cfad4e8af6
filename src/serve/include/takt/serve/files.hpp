// File records: functions 20 and 21 (MODBUS Application Protocol V1.1b3, sections 6.14, 6.15).
#pragma once

#include <cstdint>
#include <span>

#include "takt/serve/server.hpp"

namespace takt::serve {

/// Records of one register each, from 0 on.
struct File {
    static constexpr std::size_t kMostRecords = 10000;

    std::uint16_t number = 1;          ///< 1..65535
    std::span<std::uint16_t> records;  ///< at most kMostRecords
    bool read_only = false;
};

/// Answers functions 20 and 21 from files. All parts of a request are checked before any is executed. An
/// invalid byte count, reference type or length, or an answer that would not fit, is exception 3. A file or
/// record that does not exist (or is read-only) is exception 2. A broadcast writes.
class Files final : public Extension {
public:
    /// Called after records were written, from inside Server::handle().
    class Observer {
    public:
        virtual void written(const Context& context, const File& file, std::uint16_t record,
                             std::uint16_t count) = 0;

    protected:
        ~Observer() = default;
    };

    /// @param files     live as long as the extension
    /// @param observer  likewise; may be absent
    explicit Files(std::span<const File> files, Observer* observer = nullptr)
        : files_(files), observer_(observer) {}

    bool handle(Unit& unit, const Context& context, const wire::RequestView& request,
                Answer& answer) override;

private:
    [[nodiscard]] const File* find(const wire::FilePart& part) const;
    [[nodiscard]] bool exist(wire::FileParts parts, bool writable) const;
    void read(wire::FileParts parts, Answer& answer) const;
    void write(const Context& context, wire::FileParts parts) const;

    std::span<const File> files_;
    Observer* observer_;
};

}  // namespace takt::serve
