#include "database.hpp"

#include <sqlite3.h>

#include <cerrno>

namespace takt::store {
namespace {

constexpr int kLockWait = 500;  // ms: another program that begins at the same moment, or ends

std::unexpected<Error> error_of(const std::string& path, int result, int system_error) {
    const int unknown = system_error != 0 ? system_error : EIO;
    switch (result & 0xFF) {
        case SQLITE_BUSY:
        case SQLITE_LOCKED: return fail(Code::busy, path);
        case SQLITE_CORRUPT:
        case SQLITE_NOTADB: return fail(Code::malformed, path);
        case SQLITE_FULL: return fail(Code::io_failed, path, ENOSPC);
        case SQLITE_READONLY: return fail(Code::cannot_open, path, EACCES);
        case SQLITE_CANTOPEN: return fail(Code::cannot_open, path, unknown);
        default: return fail(Code::io_failed, path, unknown);
    }
}

}  // namespace

void Database::Close::operator()(sqlite3* database) const {
    sqlite3_close(database);
}

Result<Database> Database::open(const std::string& path, bool read_only) {
    sqlite3* handle = nullptr;
    const int mode = read_only ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    const int result = sqlite3_open_v2(path.c_str(), &handle, mode | SQLITE_OPEN_NOMUTEX, nullptr);
    Database database(handle, path);
    if (result != SQLITE_OK) return error_of(path, result, handle ? sqlite3_system_errno(handle) : ENOMEM);
    sqlite3_extended_result_codes(handle, 1);
    if (!read_only) sqlite3_busy_timeout(handle, kLockWait);
    return database;
}

std::unexpected<Error> Database::failure() const {
    return error_of(path_, sqlite3_extended_errcode(database_.get()), sqlite3_system_errno(database_.get()));
}

Result<void> Database::execute(const char* sql) {
    if (sqlite3_exec(database_.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) return failure();
    return {};
}

Result<Statement> Database::prepare(std::string_view sql) {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database_.get(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr) !=
        SQLITE_OK)
        return failure();
    return Statement(*this, statement);
}

Result<std::int64_t> Database::number(std::string_view sql) {
    TAKT_TRY(Statement statement, prepare(sql));
    TAKT_TRY(const bool there, statement.step());
    return there ? statement.number(0) : 0;
}

Result<std::string> Database::text(std::string_view sql) {
    TAKT_TRY(Statement statement, prepare(sql));
    TAKT_TRY(const bool there, statement.step());
    return there ? statement.text(0) : std::string();
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const {
    sqlite3_finalize(statement);
}

void Statement::bind(int parameter, std::string_view text) {
    sqlite3_bind_text(statement_.get(), parameter, text.data(), static_cast<int>(text.size()),
                      SQLITE_TRANSIENT);
}

void Statement::bind(int parameter, std::int64_t number) {
    sqlite3_bind_int64(statement_.get(), parameter, number);
}

void Statement::bind_null(int parameter) {
    sqlite3_bind_null(statement_.get(), parameter);
}

Result<bool> Statement::step() {
    const int result = sqlite3_step(statement_.get());
    if (result == SQLITE_ROW) return true;
    if (result == SQLITE_DONE) {
        sqlite3_reset(statement_.get());
        return false;
    }
    const auto failed = database_->failure();
    sqlite3_reset(statement_.get());
    return failed;
}

bool Statement::is_null(int column) const {
    return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
}

std::string Statement::text(int column) const {
    const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement_.get(), column));
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
    return bytes ? std::string(bytes, size) : std::string();
}

std::int64_t Statement::number(int column) const {
    return sqlite3_column_int64(statement_.get(), column);
}

}  // namespace takt::store
