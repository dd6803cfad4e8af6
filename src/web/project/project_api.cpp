#include "takt/web/project_api.hpp"

#include <algorithm>
#include <chrono>
#include <expected>
#include <mutex>
#include <optional>
#include <utility>

#include "http/protected_keys.hpp"
#include "live/requests_json.hpp"
#include "project/field_table.hpp"
#include "project/import_table.hpp"
#include "project/project_parts.hpp"
#include "project/saved_project.hpp"
#include "project/take_over.hpp"
#include "project/unified_diff.hpp"
#include "takt/file/convert.hpp"
#include "takt/file/document_json.hpp"
#include "takt/file/json_members.hpp"
#include "takt/file/schema.hpp"
#include "takt/os/file_exchange.hpp"
#include "takt/report/plans/findings_report.hpp"
#include "takt/report/plans/plan_csv.hpp"
#include "takt/report/plans/plan_report.hpp"
#include "takt/report/plans/plan_svg.hpp"

namespace takt::web {

/// The body of a request.
struct SentProject {
    file::Json object;
    model::Node document;  ///< with the origins of items
};

namespace {

using file::EditError;
using file::Json;
using model::Node;
using SavedPtr = std::shared_ptr<const SavedProject>;

/// A document as JSON is larger than its file.
constexpr std::size_t kMostBodyBytes = 2 * file::kMaxFileBytes;

/// Ends an evaluation from inside its progress report.
struct Superseded {};

/// @throws Superseded  the answer is of no use
void end_if_superseded(const ApiRequest& request) {
    if (request.stop.stop_requested()) throw Superseded{};
}

ApiResponse project_refusal(const ApiRequest& request, int status, std::string_view code,
                            const report::Texts::Arguments& arguments = {}) {
    return ApiResponse::error(status, code, request.texts("web.project." + std::string(code), arguments));
}

ApiResponse project_failure(const ApiRequest& request, const Error& error) {
    return ApiResponse::error(error.code == Code::not_found ? 404 : 500, "file",
                              request.texts.describe(error));
}

ApiResponse project_failure(const ApiRequest& request, const EditError& error) {
    constexpr std::array<std::string_view, 5> kCodes{"unreadable", "layout", "origin", "too_large",
                                                     "differs"};
    return project_refusal(request, 422, kCodes[static_cast<std::size_t>(error.kind)],
                           {{"subject", error.subject}});
}

std::expected<SentProject, ApiResponse> sent_in(const ApiRequest& request, const Node* original) {
    auto object = Json::parse(request.body, kMostBodyBytes);
    if (!object) return std::unexpected(project_refusal(request, 400, "malformed", {{"subject", "JSON"}}));
    const auto* const json = object->find("document");
    if (json == nullptr)
        return std::unexpected(project_refusal(request, 400, "malformed", {{"subject", "document"}}));
    auto document = file::document_of(*json, original);
    if (!document)
        return std::unexpected(
            document.error().code == Code::too_long
                ? project_refusal(request, 422, "too_large")
                : project_refusal(request, 400, "malformed",
                                  {{"subject", std::string(document.error().subject.view())}}));
    return SentProject{*std::move(object), *std::move(document)};
}

std::optional<ApiResponse> missing_member(const ApiRequest& request, const Json& object,
                                          std::string_view key) {
    if (file::text_in(file::member(object, key)) != nullptr) return std::nullopt;
    return project_refusal(request, 400, "malformed", {{"subject", std::string(key)}});
}

const Node* root_of(const SavedPtr& saved) {
    return saved->alone.readable ? &saved->alone.document.root : nullptr;
}

bool is_editable(const SavedPtr& saved) {
    return saved->alone.readable && saved->alone.findings.empty() &&
           saved->alone.document.root.kind == Node::Kind::mapping;
}

const model::Finding* first_error(const std::vector<model::Finding>& findings) {
    const auto error = std::ranges::find(findings, model::Severity::error, &model::Finding::severity);
    return error == findings.end() ? nullptr : &*error;
}

std::string file_name(const std::string& path) {
    return path.substr(path.rfind('/') + 1);
}

}  // namespace

struct ProjectApi::Impl {
    explicit Impl(ProjectApiOptions given) : options(std::move(given)), disk(options.file) {}

    using Handler = ApiResponse (Impl::*)(const ApiRequest&, const SavedPtr&);

    /// A handler of the project's file.
    ApiHandler with_file(Handler handler) {
        return [this, handler](const ApiRequest& request) -> ApiResponse {
            if (options.file.empty()) return project_refusal(request, 404, "none");
            const auto saved = disk.read();
            if (!saved) return project_failure(request, saved.error());
            return (this->*handler)(request, *saved);
        };
    }

    ApiResponse project(const ApiRequest& request, const SavedPtr& saved) {
        auto read = file::load_text(options.file, saved->text, file::file_reader());
        auto parts = Json::array();
        if (is_editable(saved)) parts = read_only_parts(*root_of(saved), read.document.root, options.file);
        const TemplateParts shifted(saved->alone.document.root, read.document.root);
        auto loaded = host::interpreted(std::move(read));
        static_cast<void>(host::recall_learnt(loaded, options.file));
        host::check_output_files(loaded, options.file);
        shifted.correct(loaded.findings);
        auto object = Json::object();
        object.set("file", options.file);
        object.set("revision", saved->revision);
        object.set("document", is_editable(saved) ? file::document_json(*root_of(saved)) : Json());
        object.set("findings", report::findings_json(request.texts, loaded));
        object.set("read_only_parts", std::move(parts));
        return ApiResponse::json(object);
    }

    ApiResponse evaluate(const ApiRequest& request, const SavedPtr& saved) {
        const auto begin = std::chrono::steady_clock::now();
        try {
            end_if_superseded(request);
            auto sent = sent_in(request, root_of(saved));
            if (!sent) return std::move(sent.error());
            const auto draft = proved(request, saved, std::move(sent->document));
            if (const auto as = request.parameter("as"); !as.empty()) return exported(request, draft, as);
            auto object = plan_object(request, draft);
            object.set("courses", courses(draft));
            const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
            object.set("took_ms", took.count());
            return ApiResponse::json(object);
        } catch (const Superseded&) {
            return project_refusal(request, 409, "superseded");
        }
    }

    struct Draft {
        host::LoadedProject loaded;
        std::optional<plan::Proof> proof;  ///< nothing: the project has errors
    };

    Draft proved(const ApiRequest& request, const SavedPtr& saved, Node document) const {
        end_if_superseded(request);
        file::without_origins(document);
        const auto own = document;
        auto read = file::load_document(options.file, std::move(document),
                                        restricted_reader(options.file, saved->alone.document.root));
        const TemplateParts shifted(own, read.document.root);
        end_if_superseded(request);
        Draft draft{.loaded = host::interpreted(std::move(read)), .proof = {}};
        auto& loaded = draft.loaded;
        static_cast<void>(host::recall_learnt(loaded, options.file));
        end_if_superseded(request);
        if (!loaded.has_errors()) {
            draft.proof = host::prove(loaded, false, request.parameter("measures") == "1",
                                      [&](std::size_t, std::size_t) { end_if_superseded(request); });
            host::add_findings(loaded, *draft.proof);
        }
        shifted.correct(loaded.findings);
        return draft;
    }

    static Json plan_object(const ApiRequest& request, const Draft& draft) {
        if (!draft.proof) return report::no_plan_json(request.texts, draft.loaded);
        return report::project_plan_json(request.texts, draft.loaded, *draft.proof, nullptr, true);
    }

    /// Of each line, in the order of the plan.
    static Json courses(const Draft& draft) {
        auto all = Json::array();
        if (draft.proof)
            for (const auto& planned : draft.proof->plan.lines)
                all.push_back(course_json(draft.loaded.project.lines[planned.line], planned));
        return all;
    }

    /// The formed requests as a file.
    ApiResponse exported(const ApiRequest& request, const Draft& draft, std::string_view as) const {
        if (!draft.proof)
            return not_valid(request,
                             report::findings_json(request.texts, draft.loaded.files, draft.loaded.findings));
        const auto name = file_name(options.file);
        const auto base = name.substr(0, name.rfind('.')) + ".requests.";
        if (as == "svg")
            return {.content_type = "image/svg+xml",
                    .body = report::plan_svg(request.texts, name, draft.loaded.project, draft.proof->plan),
                    .file_name = base + "svg"};
        const auto object = plan_object(request, draft);
        if (as == "csv")
            return {.content_type = "text/csv; charset=utf-8",
                    .body = report::plan_csv(object),
                    .file_name = base + "csv"};
        if (as == "json") return {.body = object.dump(2) + '\n', .file_name = base + "json"};
        return project_refusal(request, 400, "malformed", {{"subject", "as"}});
    }

    /// The body of a request, and the text of the file with its changes.
    struct Edited {
        SentProject sent;
        std::string text;
    };

    std::expected<Edited, ApiResponse> edited(const ApiRequest& request, const SavedPtr& saved) const {
        auto sent = sent_in(request, root_of(saved));
        if (!sent) return std::unexpected(std::move(sent.error()));
        if (auto missing = missing_member(request, sent->object, "revision"))
            return std::unexpected(*std::move(missing));
        if (string_member(sent->object, "revision") != saved->revision)
            return std::unexpected(
                project_refusal(request, 409, "changed_on_disk", {{"file", options.file}}));
        auto text = file::patched_project(saved->text, sent->document);
        if (!text) return std::unexpected(project_failure(request, text.error()));
        return Edited{*std::move(sent), *std::move(text)};
    }

    ApiResponse diff(const ApiRequest& request, const SavedPtr& saved) {
        const auto wanted = edited(request, saved);
        if (!wanted) return wanted.error();
        const auto name = file_name(options.file);
        auto object = Json::object();
        object.set("diff", unified_diff(saved->text, wanted->text, name, name));
        return ApiResponse::json(object);
    }

    // The words of a table's cells are not those of a project file: the whole project is written and read.
    ApiResponse take_over(const ApiRequest& request, const SavedPtr& saved) {
        auto sent = sent_in(request, root_of(saved));
        if (!sent) return std::move(sent.error());
        if (auto missing = missing_member(request, sent->object, "path")) return *std::move(missing);
        file::without_origins(sent->document);
        auto read = file::load_document(options.file, std::move(sent->document),
                                        restricted_reader(options.file, saved->alone.document.root));
        const auto path = string_member(sent->object, "path");
        if (const auto* const error = first_error(read.findings))
            return project_refusal(request, 422, "take_over", {{"subject", request.texts.message(*error)}});
        const auto written = file::read_project_text(options.file, file::write_project(read.document.root));
        const auto taken = written.readable ? taken_over(*sent->object.find("document"),
                                                         file::document_json(written.document.root), path)
                                            : std::nullopt;
        if (!taken) return project_refusal(request, 422, "take_over", {{"subject", path}});
        auto object = Json::object();
        object.set("path", taken->path);
        object.set("value", taken->value);
        return ApiResponse::json(object);
    }

    ApiResponse save(const ApiRequest& request, const SavedPtr&) {
        const std::scoped_lock one_at_a_time(saving);
        const auto saved = disk.read();
        if (!saved) return project_failure(request, saved.error());
        auto wanted = edited(request, *saved);
        if (!wanted) return std::move(wanted.error());
        const auto& old = (*saved)->alone.document.root;
        if (const auto key = redirecting_key(old, wanted->sent.document); !key.empty())
            return project_refusal(request, 403, "protected", {{"key", key}, {"file", options.file}});
        if (const auto key = new_protected_key(old, wanted->sent.document); !key.empty())
            return project_refusal(request, 403, "protected_key", {{"key", key}, {"file", options.file}});
        auto read = file::load_text(options.file, wanted->text, restricted_reader(options.file, old));
        const TemplateParts shifted(wanted->sent.document, read.document.root);
        auto loaded = host::interpreted(std::move(read));
        static_cast<void>(host::recall_learnt(loaded, options.file));
        host::check_output_files(loaded, options.file);
        auto shown = loaded.findings;
        shifted.correct(shown);
        auto findings = report::findings_json(request.texts, loaded.files, shown);
        if (loaded.has_errors()) return not_valid(request, std::move(findings));
        const auto written = write((*saved)->text, wanted->text);
        if (!written) return project_failure(request, written.error());
        if (!written->replaced) return changed_meanwhile(request, written->kept);
        auto object = Json::object();
        object.set("revision", revision_of(wanted->text));
        object.set("backup", written->backup.empty() ? Json() : Json(written->backup));
        apply(request, std::move(loaded), flag_member(wanted->sent.object, "apply"), object);
        object.set("findings", std::move(findings));
        return ApiResponse::json(object);
    }

    static ApiResponse not_valid(const ApiRequest& request, Json findings) {
        auto error = Json::object();
        error.set("code", "findings");
        error.set("text", request.texts("web.project.findings"));
        auto object = Json::object();
        object.set("error", std::move(error));
        object.set("findings", std::move(findings));
        return ApiResponse::json(object, 422);
    }

    [[nodiscard]] Result<os::Exchanged> write(const std::string& old_text,
                                              const std::string& new_text) const {
        if (old_text == new_text) return os::Exchanged{.replaced = true, .backup = {}, .kept = {}};
        return os::exchange_file(options.file, new_text, old_text);
    }

    [[nodiscard]] ApiResponse changed_meanwhile(const ApiRequest& request,
                                                const std::vector<std::string>& kept) const {
        if (kept.empty()) return project_refusal(request, 409, "changed_on_disk", {{"file", options.file}});
        return ApiResponse::error(
            409, "changed_on_disk",
            request.texts("web.project.changed_twice", {{"file", options.file}, {"kept", kept.front()}}));
    }

    void apply(const ApiRequest& request, host::LoadedProject loaded, bool wanted, Json& object) const {
        const bool possible = wanted && options.apply;
        const auto applied = possible ? options.apply(std::move(loaded)) : Result<void>();
        object.set("applied", possible && applied.has_value());
        if (!applied) object.set("apply_error", request.texts.describe(applied.error()));
    }

    ProjectApiOptions options;
    ProjectOnDisk disk;
    std::mutex saving;  // saves and applications, one at a time
};

ProjectApi::ProjectApi(ProjectApiOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {}

ProjectApi::~ProjectApi() = default;

std::vector<ApiRoute> ProjectApi::routes() {
    auto& impl = *impl_;
    const auto schema = [](const ApiRequest&) { return ApiResponse::json(file::project_schema()); };
    return {
        {.method = Method::get, .path = "/project", .handler = impl.with_file(&Impl::project)},
        {.method = Method::post,
         .path = "/project/evaluate",
         .handler = impl.with_file(&Impl::evaluate),
         .work = Work::planning,
         .newest_only = true},
        {.method = Method::post, .path = "/project/diff", .handler = impl.with_file(&Impl::diff)},
        {.method = Method::post,
         .path = "/project/take_over",
         .changes = true,
         .handler = impl.with_file(&Impl::take_over)},
        {.method = Method::put, .path = "/project", .changes = true, .handler = impl.with_file(&Impl::save)},
        {.method = Method::get, .path = "/fields", .handler = field_table},
        {.method = Method::get, .path = "/schema", .handler = schema},
        {.method = Method::post, .path = "/import", .handler = import_table},
    };
}

}  // namespace takt::web
