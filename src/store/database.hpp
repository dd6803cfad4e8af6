// SQLite with Results and without leaks.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "takt/base/result.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace takt::store {

class Statement;

/// One connection; one thread at a time.
class Database {
public:
    /// @returns cannot_open, busy
    [[nodiscard]] static Result<Database> open(const std::string& path, bool read_only);

    [[nodiscard]] Result<void> execute(const char* sql);
    [[nodiscard]] Result<Statement> prepare(std::string_view sql);
    /// The first column of the first row.
    [[nodiscard]] Result<std::int64_t> number(std::string_view sql);
    [[nodiscard]] Result<std::string> text(std::string_view sql);

    /// The last failure as an error: busy, malformed (damaged, or no database), io_failed.
    [[nodiscard]] std::unexpected<Error> failure() const;

private:
    struct Close {
        void operator()(sqlite3* database) const;
    };
    explicit Database(sqlite3* database, std::string path) : database_(database), path_(std::move(path)) {}

    std::unique_ptr<sqlite3, Close> database_;
    std::string path_;
};

/// A prepared statement; its Database must outlive it.
class Statement {
public:
    void bind(int parameter, std::string_view text);
    void bind(int parameter, std::int64_t number);
    void bind_null(int parameter);

    /// The next row. @returns false when there is none; then it may be bound and stepped anew
    [[nodiscard]] Result<bool> step();

    [[nodiscard]] bool is_null(int column) const;
    [[nodiscard]] std::string text(int column) const;
    [[nodiscard]] std::int64_t number(int column) const;

private:
    friend class Database;
    struct Finalize {
        void operator()(sqlite3_stmt* statement) const;
    };
    Statement(const Database& database, sqlite3_stmt* statement)
        : database_(&database), statement_(statement) {}

    const Database* database_;
    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

}  // namespace takt::store
